#pragma once

#include <cstdint>
#include <functional>

#include "common/config/vehicle_config.hpp"
#include "common/link/blocks.hpp"

namespace roadbalance {

/// Reads a front end to its end and hands over every block of the epoch, as a node would seal them: for
/// import and studies, without threads and without a bus.
///
/// @param jump  cause of a jump in the front end's scan index
/// @throws std::runtime_error if the front end fails; what `take` throws
void seal_all(FrontEnd& front_end, const VehicleConfig& vehicle, const NodeConfig& node, std::int64_t epoch,
              const std::function<void(const SealedBlock&)>& take, GapCause jump = GapCause::kDeviceOverrun);

}  // namespace roadbalance
