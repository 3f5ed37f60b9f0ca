#pragma once

#include <array>
#include <complex>
#include <span>
#include <string>

#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/vehicle/linear_model.hpp"

namespace roadbalance {

/// The car that the twin simulates.
struct TwinCar {
  Geometry geometry;
  ParameterVector parameters;
  std::array<std::complex<double>, kWheels> unbalance_kg_m{};  ///< 0: not known, or none
  std::array<double, kWheels> rolling_radius_m{};
  bool identified = false;              ///< springs, dampers, stabilisers, tyres are those of a drive
  std::array<bool, kWheels> balance{};  ///< its unbalance is that of a drive

  /// As vehicle.toml has it, wheels in balance.
  static TwinCar nominal(const VehicleConfig& vehicle);

  /// The estimated values; the rest, or all of a car that is not identified, as vehicle.toml has it.
  /// An estimate with a value that no car has (not finite; a spring, damper or tyre of 0 or less) counts as
  /// none, and so does such a balance.
  /// Where a force that does not grow with speed was separated the wheel's unbalance is the equivalent one.
  static TwinCar estimated(const VehicleConfig& vehicle, const Identification& identification,
                           std::span<const Balance> balance);
};

/// By which share of b's the two differ at most in a spring, damper or tyre, or in a stabiliser as a share of
/// the springs of its axle: a car may have none.
double greatest_difference(const TwinCar& a, const TwinCar& b);

}  // namespace roadbalance
