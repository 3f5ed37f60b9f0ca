#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/identify/posterior_car.hpp"

namespace roadbalance {

/// Deviation::sigmas from which an estimate is refused: what is taken for known of the car is not true of it.
/// One that is right comes so far once in 50 000 drives of 40 quantities.
inline constexpr double kMostSigmas = 5.0;
/// And from which it is told: once in 50 drives of a car that is as vehicle.toml has it.
inline constexpr double kToldSigmas = 3.5;

/// Why an estimate of the whole car is not to be given, and what a driver can do about it; empty: it may be.
/// The quantity that is farthest off is named.
///
/// @param car  nothing: the drive's posterior has no clear mode
std::string refusal(const std::optional<PosteriorCar>& car, const CarPrior& prior,
                    const VehicleConfig& vehicle);

/// What the estimate rests on, and how well that is known: no drive shows it.
std::string remark_on_scale(const PosteriorCar& car);

/// What the drive shows of car and sensors beyond vehicle.toml, and what to do about it: the quantity that is
/// farthest off, and struts whose dry friction is certain and greater than a good strut's.  The estimate has
/// taken them up.
std::vector<std::string> remarks_on_deviations(const std::optional<PosteriorCar>& car, const CarPrior& prior,
                                               const VehicleConfig& vehicle);

}  // namespace roadbalance
