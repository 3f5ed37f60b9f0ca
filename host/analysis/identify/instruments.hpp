#pragma once

#include "common/dsp/linear_filter.hpp"

namespace roadbalance {

/// A filter of an acceleration whose states, scaled companion form of order 5, make instruments W with two
/// derivatives: (W, W', W'') = (y_j / wc^2, y_(j+1) / wc, y_(j+2)), wc = 2 pi corner_hz.  It looks at the
/// past: accelerations are taken lag_s later.
struct Instrument {
  ContinuousFilter filter;
  double corner_hz;
  double lag_s;
};

inline constexpr int kInstrumentOrder = 5;

/// For the body's rows, of each of the seven accelerations, j = 0, 1, 2: Butterworth, 15 Hz, 20 ms.
Instrument chassis_instrument();

/// For a tyre, of the wheel's own acceleration, j = 0: s^2 / ((s + wl)^2 B3(s / wh)), flat from 1 to 80 Hz,
/// 4 ms.  After that the contact patch has left next to nothing of the road; at 20 ms E[W z] is about 0.
Instrument tyre_instrument();

}  // namespace roadbalance
