#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/analysis/identify/drive_groups.hpp"
#include "host/analysis/identify/estimate.hpp"
#include "host/analysis/identify/speed_classes.hpp"

namespace roadbalance {

/// How far an estimate is to be trusted.
struct EstimateCovariance {
  UnknownMatrix drive;  ///< by what the drive scatters: jackknife, widened for few groups
  /// By how much the drives' variance of each wheel's unbalance is that of their sections; 1: a single drive.
  std::array<double, kWheels> drives_ratio{1.0, 1.0, 1.0, 1.0};
  /// Factor of each unknown's variance for that.
  UnknownVector drives_widening = UnknownVector::Ones();
};

/// Values of the car that identification does not estimate, and how well they are known.
struct Priors {
  Geometry geometry;
  ParameterVector value;
  ParameterVector sigma;  ///< how well, one standard deviation each; 0 of what is estimated
  Eigen::Vector4d rolling_radius_m;

  static Priors of(const VehicleConfig& vehicle);
};

/// For several drives the scatter of sections is widened to that of whole drives, each unknown by itself,
/// where drives differ by more: Birge's ratio, never below 1.  The part that it adds rests on a few drives
/// only, and counts for more the fewer they are (few_drives_factor).
///
/// Source: R. T. Birge, The calculation of errors by the method of least squares, Phys. Rev. 40 (1932)
/// 207-227.
/// Returns nothing if a part of the drive does not determine the unknowns, or it has fewer than four groups.
std::optional<EstimateCovariance> estimate_covariance(const SpeedClasses& drive, const Priors& priors,
                                                      const DriveGroups& drives = {});

/// Variance of an estimate by what leaving out whole drives changes, drives counting unequally.
///
///     variance = sum (1 - p_j) (x - x_(j))^2,  p_j = m_j / sum m
///
/// For a mean of values that scatter as 1 / m_j it has no bias; and as no drive's share is divided by its
/// weight, a light one whose weight is a little wrong does not decide, as it would in the delete-m_j
/// jackknife (of one car on roads of class A, B and C it gave 1.7 times too large a variance).
///
/// Source: J. G. MacKinnon and H. White, Some heteroskedasticity-consistent covariance matrix estimators with
/// improved finite sample properties, J. Econometrics 29 (1985) 305-325, HC2, of drives for observations.
/// @param whole     the estimate from all
/// @param left_out  [unknown x group] without that group
/// @param weight    m_j > 0 of each group, two at least
Eigen::VectorXd variance_between(const Eigen::VectorXd& whole, const Eigen::MatrixXd& left_out,
                                 const Eigen::VectorXd& weight);

}  // namespace roadbalance
