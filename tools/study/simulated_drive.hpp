#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/identify/drive_estimator.hpp"

namespace roadbalance {

/// One drive of the simulated car, as its nodes would send it: each block in the order of its node, those of
/// different nodes interleaved.
/// @param address        as sim/address.hpp has it
/// @param converter_ppm  of each node's converter; those not named are at their nominal rate
/// @throws ConfigError
void simulate_drive(const VehicleConfig& vehicle, const std::string& address,
                    const std::vector<double>& converter_ppm,
                    const std::function<void(const SealedBlock&)>& consume);

/// Identification of one drive of the simulated car, its nodes and the identification without bus and
/// record.
///
/// The blocks are those of simulate_drive.
/// @throws ConfigError
DriveEstimate identify_simulated_drive(const VehicleConfig& vehicle, const std::string& address,
                                       const std::vector<double>& converter_ppm = {});

}  // namespace roadbalance
