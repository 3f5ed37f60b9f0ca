#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "common/process/channel.hpp"
#include "host/analysis/balance/check_weights.hpp"

namespace roadbalance {

/// A finished recording and its estimate.
///
/// @param stop  asked between blocks
/// @throws as identify_record
BalancedDrive evaluate_drive(const std::filesystem::path& folder, const std::stop_token& stop = {});

/// The newest of the recordings beside this one between which and it weights were fitted, as their
/// vehicle.toml have it (weights_were_fitted_between); nothing: there is none.
///
/// So neither a page nor an analyser that was started again has anything to remember.
std::optional<std::filesystem::path> drive_before_weights(const std::filesystem::path& record,
                                                          const VehicleConfig& vehicle);

/// Process: the recording of the drive before -> its estimate, once.  It may take a while: an hour's drive a
/// minute.  One that cannot be read is a warning, and nothing is sent: the drive of now matters more.
void recall_before(std::stop_token stop, const std::filesystem::path& folder, Out<BalancedDrive> drive,
                   const std::function<void(const std::string&)>& warn);

}  // namespace roadbalance
