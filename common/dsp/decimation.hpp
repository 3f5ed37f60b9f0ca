#pragma once

#include <Eigen/Core>

namespace roadbalance {

/// Low-pass to take every `factor`-th sample behind: Kaiser-windowed sinc with linear phase, gain 1 at rest,
/// cut-off at 0.4 of the new rate, 8 new samples to each side, beta = 8 (stop band -81 dB).
///
/// In units of the new rate it passes 0 .. kDecimationFlatTo unchanged to 2e-4 and stops all from
/// kDecimationStopsFrom on, so that nothing folds to below 1 - kDecimationStopsFrom.
///
/// @param factor  >= 1; 1 passes all: one tap
/// @return  16 factor + 1 taps
Eigen::VectorXd decimation_taps(int factor);
inline constexpr double kDecimationFlatTo = 0.24;
inline constexpr double kDecimationStopsFrom = 0.56;

/// The same for data that is kept: nothing folds at all, and four fifths of what the new rate can carry is
/// left.  Cut-off at 0.45 of the new rate, kReductionHalf new samples to each side, beta = 10.1 (stop band
/// -100 dB; A. Oppenheim, R. Schafer, Discrete-Time Signal Processing, 7.6: beta = 0.1102 (A - 8.7), and
/// (A - 7.95) / (2.285 width) taps more than one).
///
/// In units of the new rate it passes 0 .. kReductionFlatTo unchanged to kReductionRipple and stops all from
/// half the new rate on to as much.
///
/// @param factor  >= 1; 1 passes all: one tap
/// @return  2 kReductionHalf factor + 1 taps
Eigen::VectorXd reduction_taps(int factor);
inline constexpr int kReductionHalf = 34;
inline constexpr double kReductionFlatTo = 0.4;
inline constexpr double kReductionRipple = 1.2e-5;

}  // namespace roadbalance
