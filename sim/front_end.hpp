#pragma once

#include <memory>

#include "common/frontend/registry.hpp"

namespace roadbalance::sim {

/// Opens one node of the simulated car; address.hpp lists the forms of request.address.
///
/// Bus time 0 is the start of the drive, scan k of the drive is taken at k / rate_hz (of the converter, which
/// may be off its nominal rate), and after the drive the device ends.  Samples are a function of bus time
/// alone, whatever a node's clock shows.  Every node process simulates the whole car for itself and they all
/// see the same one. A node opened late (start_ns in the past, or from=) brings the car to the present
/// silently: its scan index begins at 0, its times and data are those of a node that was there all along, bit
/// for bit.
///
/// With a rate the device hands over what is due by the wall clock, in runs of 5 ms of wall time; with
/// rate=max it hands over as much as is asked for.  At any rate but 1 it waits for its reader.
///
/// @throws ConfigError naming the key of address, scenario or vehicle at fault
std::unique_ptr<FrontEnd> open_sim_front_end(const FrontEndRequest& request);

}  // namespace roadbalance::sim
