#pragma once

#include <array>
#include <complex>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/analysis/identify/estimators/estimator.hpp"
#include "tools/study/ideal_drive.hpp"

namespace roadbalance {

/// True values of the quantities that an estimator estimates.
struct CarTruth {
  ParameterVector parameters;
  std::array<std::complex<double>, kWheels> unbalance_kg_m;
};

/// True values of the car of such a drive.
CarTruth truth_of(const IdealDrive& drive, std::uint64_t seed, const VehicleConfig& vehicle);

/// The first `samples` of each stretch, or all there are.
std::vector<Stretch> shortened(std::span<const Stretch> stretches, Eigen::Index samples);

/// Estimates of one estimator from these stretches.  `known-tyre` gets the true tyres and takes them as
/// known.
EstimatorAnswer ask(const EstimatorKind& kind, const Question& question, const CarTruth& truth,
                    std::span<const Stretch> stretches);

/// Errors of an answer about a wheel of the truth:
///
///     {"tyre_percent", "mass_percent", "angle_deg",        its errors
///      "re_percent", "im_percent",                         of U / U_true - 1
///      "residual_kg_m",                                     |U - U_true|
///      "tyre_sigma_percent", "mass_sigma_percent", "angle_sigma_deg"}   as the estimator states them
///
/// null: not known.  A wheel that is balanced in truth has "residual_kg_m" only.
nlohmann::ordered_json errors_of(const EstimatorAnswer& answer, const CarTruth& truth, int wheel);

/// Estimators of a comma-separated list, or with an empty one all that are not asked for the whole car.
/// @throws ConfigError naming the estimators there are
std::vector<EstimatorKind> chosen_estimators(const std::string& names);

/// The sheet's car: sim/demo/vehicle.toml.
VehicleConfig demo_vehicle();

/// The demo's scenario without spreads, unbalances and radial forces.
sim::Scenario plain_scenario(const VehicleConfig& vehicle);

/// n speeds from `low` to `high`, both included, km/h to m/s.
std::vector<double> speeds_between(double low_km_h, double high_km_h, int n);

}  // namespace roadbalance
