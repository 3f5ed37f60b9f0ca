#pragma once

#include <functional>
#include <stop_token>
#include <string>

#include "common/config/vehicle_config.hpp"

namespace roadbalance {

/// Process: blocks and previews from the bus -> levels ten times and spectra once a second (wall time), and
/// what somebody wants to see (View): transfer functions and spectra ten times, envelopes twenty times, order
/// spectra by speed once a second.
///
/// It asks nobody for repairs: what it did not see it counts in Level::skipped.
/// @param warn  hears who is of another version of the wire
void live_view(std::stop_token stop, const std::string& url, const VehicleConfig& vehicle,
               const std::function<void(const std::string&)>& warn);

}  // namespace roadbalance
