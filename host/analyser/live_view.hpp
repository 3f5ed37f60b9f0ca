#pragma once

#include <functional>
#include <stop_token>
#include <string>

#include "common/bus/control_messages.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/process/channel.hpp"
#include "host/analyser/chosen_vehicle.hpp"

namespace roadbalance {

/// Process: blocks and previews from the bus -> levels ten times and spectra once a second of each node's
/// samples (SampleBeat), the same when they are played again; and what viewers ask for (View):
/// transfer functions and spectra ten times, envelopes twenty times, order spectra by speed once a second
/// (wall time).
///
/// It asks for no repairs: scans that it did not see are counted in Level::skipped.  When the nodes measure
/// by another vehicle.toml it goes by that (ChosenVehicle).
/// @param find  may be empty: it always goes by `vehicle`
/// @param warn  hears who is of another version of the wire
/// @param acks  gets the recorder's acknowledgements, which come again, as far as there is room
void live_view(std::stop_token stop, const std::string& url, const VehicleConfig& vehicle,
               const VehicleByCrc& find, const std::function<void(const std::string&)>& warn, Out<Ack> acks);

}  // namespace roadbalance
