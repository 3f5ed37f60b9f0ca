#pragma once

#include <Eigen/Core>

namespace roadbalance {

/// Values between the samples of a band-limited signal: the value at n + fraction is the sum over k of
/// taps(fraction)(k) * x(n + k - kBefore).
///
/// 32 taps of sinc under a Kaiser window, beta = 10, gain 1 at rest; T. Laakso et al., Splitting the unit
/// delay, IEEE SP Magazine 13 (1996) 30, section on windowing.  Taps come from a table of 256 fractions,
/// linear between them.  Up to 0.38 of the sample rate gain and phase are those of a pure delay to 3e-5 and
/// 0.001 degrees, so that nothing has to be corrected afterwards; fraction 0 gives the sample itself.
class FractionalDelay {
 public:
  static constexpr int kTaps = 32;
  static constexpr int kBefore = 15;  ///< samples needed before the one at or before the wanted instant
  static constexpr int kAfter = 16;   ///< samples needed behind it
  using Taps = Eigen::Matrix<double, kTaps, 1>;

  /// @param fraction  0 .. 1
  Taps taps(double fraction) const;

 private:
  static constexpr int kFractions = 256;
  using Table = Eigen::Matrix<double, kTaps, kFractions + 1>;
  static const Table& table();

  const Table* table_ = &table();
};

}  // namespace roadbalance
