#pragma once

#include <optional>
#include <vector>

namespace roadbalance {

/// The amplitude of a run with the trial weight at an angle of the plane.
struct AmplitudeRun {
  double angle_rad;  ///< of the weight, from any mark on the rotor
  double amplitude;
  double sigma;  ///< of it, >= 0
};

/// A correction weight found without any phase.
struct FourRunBalance {
  double mass;       ///< in the trial weight's unit
  double angle_rad;  ///< from the same mark, 0 .. 2 pi
  double mass_sigma, angle_sigma_rad;
  /// The trial weight's answer by the runs' course over the angle, over that by their mean; 1 if the rotor
  /// answers linearly.
  double agreement;
};

/// One plane, one channel, no phase: the bare rotor and the same trial weight at three or more angles.
///
/// With V the bare rotor's answer and T that of the trial weight the runs show
/// |V + T e^{j theta}|^2 = V^2 + T^2 + 2 V T cos(theta - phi): a mean and a sine over theta by least squares.
/// The weight that brings V to nothing is trial V / T at phi + 180 degrees, T from the mean.
///
/// Source: K. R. Hopkirk, Notes on methods of balancing, The Engineer 170 (1940); the four-run method.
/// @param trial_mass  > 0
/// @throws std::invalid_argument if it is not, or a sigma is negative
/// @return nothing if there are fewer than three different angles, the trial weight's answer is lost in what
/// the
///         amplitudes scatter, or the runs contradict one another (agreement off 1 by more than kDisagreement
///         and three standard deviations)
std::optional<FourRunBalance> balance_by_four_runs(const AmplitudeRun& bare,
                                                   const std::vector<AmplitudeRun>& trials,
                                                   double trial_mass);
inline constexpr double kDisagreement = 0.2;

}  // namespace roadbalance
