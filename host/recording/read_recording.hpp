#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "common/config/vehicle_config.hpp"
#include "common/record/log_event.hpp"
#include "common/types/block.hpp"
#include "common/types/exchange.hpp"

namespace roadbalance {

/// Defects that keep a recording from being complete; all zero: nothing is missing undeclared.
struct RecordingDefects {
  std::uint64_t damaged_bytes = 0;  ///< except the torn tail of a kill or a power cut
  std::int64_t refused_blocks = 0;  ///< with a wrong CRC, size or content
  std::int64_t missing_blocks = 0;  ///< whose number was skipped

  bool any() const { return damaged_bytes > 0 || refused_blocks > 0 || missing_blocks > 0; }
};

/// Calls back for every block of a finished recording, each node's in sequence, as the live analyser receives
/// them. Damage costs the blocks it hit and no more.
///
/// @param begin    called once, before the first block
/// @param consume  called with each block
/// @param consume_fit  called with each fit of a node's clock, between the blocks as it stands in the record
/// @param consume_other  called with each event that is no block: notes, journal entries, clocks
/// @throws std::system_error if the folder cannot be read, std::runtime_error if it holds no vehicle.toml or
///         no scan, ConfigError if its vehicle.toml cannot be used
RecordingDefects read_recording(const std::filesystem::path& folder,
                                const std::function<void(const VehicleConfig&)>& begin,
                                const std::function<void(const SealedBlock&)>& consume,
                                const std::function<void(const ClockFit&)>& consume_fit = {},
                                const std::function<void(const LogEvent&)>& consume_other = {});

}  // namespace roadbalance
