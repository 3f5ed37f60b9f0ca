#pragma once

#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// Adds to the uncertainty of an unbalance, ellipse and sigmas alike, what its own estimate cannot show.
/// @param along   variance of its length, as a share of it squared
/// @param across  variance of its angle, rad^2
void add_variance(Balance& balance, double along, double across);

/// Variance of an unbalance, as a share of it squared and in rad^2, that the gains of the vertical sensors
/// leave: an unbalance is in proportion to what the sensor on its wheel's carrier shows, and of what moves it
/// across its direction at the same order, any phase may be in it.  Other channels' gains do less than a
/// tenth of that.  Without sensors on the carriers the body's show all wheels.
double gain_variance(const VehicleConfig& vehicle, std::size_t wheel);

}  // namespace roadbalance
