#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// The demonstration car as of one's own little is known: masses to 2 and 3 %, inertias to 10 %, tyre dampers
/// to 50 N s/m, gains to 1 %, vehicle.toml's defaults.
VehicleConfig car_of_a_stranger();

/// What is different from the ideal car, in the tables of a scenario (sim/README.md).
struct Hazard {
  std::string name;
  std::string road{}, tyre{}, damper{}, spread{}, sensor{};  ///< lines of TOML
  /// Radial force on the front left wheel, N.
  double radial_force_n = 0.0;
  /// That vehicle.toml states of the gains.
  double gain_sigma = 0.01;
};

/// One at a time.
std::span<const Hazard> hazards();
/// All drawn at once.
const Hazard& real_road();

/// A drive of the demonstration car whose masses, inertias and sensors are known no better than another's,
/// identified behind nodes, blocks, rings and the identification's grid.
struct RealDrive {
  Hazard hazard;
  std::string road_class = "A";
  std::vector<double> speeds_km_h{95.0, 107.0, 118.0, 130.0};
  double seconds = 60.0;  ///< at each speed, beside the change to it
};

/// Results against the truth, one object a wheel; null where nothing is known:
///
///     {"name", "mass_percent", "angle_deg", "residual_g", "sigma_percent", "sigma_deg", "ellipse": of the
///      correction, against the best for the speeds driven; "alone_ellipse": of the unbalance alone;
///      "force_error_n", "sigma_force_n", "force_ellipse"; "tyre_percent"}
///
/// An ellipse is (x - truth)' C^-1 (x - truth) of the stated covariance C.
/// @param folder  for the scenario's file
nlohmann::ordered_json real_drive_errors(const RealDrive& drive, std::uint64_t seed,
                                         const std::filesystem::path& folder);

}  // namespace roadbalance
