#pragma once

#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/identify/drive_estimator.hpp"

namespace roadbalance {

/// Identification of one drive of the simulated car, its nodes and the identification without bus and
/// record.
///
/// The blocks are those the nodes would send, made by the same code.
/// @param address        as sim/address.hpp has it
/// @param converter_ppm  of each node's converter; those not named are at their nominal rate
/// @throws ConfigError
DriveEstimate identify_simulated_drive(const VehicleConfig& vehicle, const std::string& address,
                                       const std::vector<double>& converter_ppm = {});

}  // namespace roadbalance
