#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"
#include "host/identify/drive_groups.hpp"
#include "host/identify/estimate.hpp"
#include "host/identify/first_order.hpp"
#include "host/identify/misfit.hpp"
#include "host/identify/speed_classes.hpp"

namespace roadbalance {

/// How far an estimate is to be trusted.
struct Judgement {
  /// Covariance by what the drive scatters (jackknife, widened for few groups) and by what masses, inertias
  /// and tyre dampers taken for known are good to.
  UnknownMatrix drive, model;
  SuspensionConditioning suspension;
  /// Body, then the wheels.  Of the body the share is that of its roll inertia.
  std::array<Misfit, 1 + kWheels> misfit{};
  /// By which share the mass of all wheels seems to differ from what is taken for known; 0 sigma: not judged.
  double mass_share = 0.0, sigma_mass_share = 0.0;
  /// By how much the drives' variance of each wheel's unbalance is that of their sections; 1: a single drive.
  std::array<double, kWheels> drives_ratio{1.0, 1.0, 1.0, 1.0};
  /// Unbalance and speed-independent force of each wheel; sigmas by what the drive scatters.
  std::array<FirstOrderFit, kWheels> first_order{};
};

/// What identification takes for known.
struct Known {
  Geometry geometry;
  ParameterVector value;
  ParameterVector sigma;  ///< how well, one standard deviation each; 0 of what is estimated
  Eigen::Vector4d rolling_radius_m;

  static Known of(const VehicleConfig& vehicle);
};

/// Of several drives the scatter of sections is widened to that of whole drives, each unknown by itself,
/// where drives differ by more: Birge's ratio, never below 1.  What it adds rests on a few drives only, and
/// counts for more the fewer they are (few_drives_factor).
///
/// Source: R. T. Birge, The calculation of errors by the method of least squares, Phys. Rev. 40 (1932)
/// 207-227.
/// Returns nothing if a part of the drive does not determine the unknowns, or it has fewer than four groups.
std::optional<Judgement> judge(const SpeedClasses& drive, const Known& known, const DriveGroups& drives = {});

}  // namespace roadbalance
