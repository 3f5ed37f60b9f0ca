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

}  // namespace roadbalance
