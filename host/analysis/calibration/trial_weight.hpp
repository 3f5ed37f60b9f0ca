#pragma once

#include <optional>

#include <Eigen/Core>

#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// A known weight that was clipped to a wheel between two drives.
struct TrialWeight {
  double mass_g;           ///< at the weight radius
  double angle_rad;        ///< from the reference point in the direction of rotation
  double angle_sigma_rad;  ///< how well it was put there
};

/// A wheel's unbalance as one drive found it.
struct FoundUnbalance {
  Eigen::Vector2d unbalance_g;    ///< (cos, sin), with the datum that the drive was analysed with
  Eigen::Matrix2d covariance_g2;  ///< of it, the datum's own uncertainty apart
  double datum_rad;

  /// @param balance  of state kNone, whose uncertainty has the encoder's datum_sigma_rad in it
  static FoundUnbalance from(const Balance& balance, const EncoderConfig& encoder);
};

/// Datum by the weight: the one at which the change of the unbalance lies where the weight is.
///
/// An unbalance at beta is found at beta + true datum - datum used, so with D the change of the unbalances
/// from the encoder's own mark, U e^(j datum used),
///
///     datum = arg D - angle of the weight,   sigma^2 = D_t' C D_t / |D|^2 + sigma^2 of the weight's angle
///
/// with C the sum of both covariances and D_t the direction across D.
struct TrialDatum {
  double datum_rad;  ///< -pi .. pi
  double sigma_rad;
  double change_g, change_sigma_g;  ///< length of D; should be the weight's mass

  /// The drives find the weight that was clipped on, within three standard deviations of theirs and 5 %.
  bool mass_agrees(const TrialWeight& weight) const;
};

/// Nothing if the drives do not show the change's direction: its sigma is 20 degrees or more.
std::optional<TrialDatum> datum_by_trial_weight(const FoundUnbalance& before, const FoundUnbalance& after,
                                                const TrialWeight& weight);

}  // namespace roadbalance
