#pragma once

namespace roadbalance {

/// Waves of the road a metre above which a tyre's contact patch evens them out: the wheel is excited by the
/// road's height behind a first-order low pass of 2 pi 4 1/m, w2 = 2 pi 4 V in time.
inline constexpr double kPatchWave_1_m = 4.0;

}  // namespace roadbalance
