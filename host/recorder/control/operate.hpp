#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>

#include "host/recorder/recorder.hpp"

namespace roadbalance {

struct OperateOptions {
  RecorderOptions recorder;          ///< of each recording; its folder is set here
  std::filesystem::path recordings;  ///< folder of the recordings, each a folder of its name
  std::filesystem::path vehicle;     ///< vehicle.toml that requests may change; empty: none
  std::optional<std::string> start;  ///< this one begins without a request
};

/// Process: waits for requests on the bus (common/bus/operation.hpp), records from a start to a stop, again
/// and again, and reports in between what would be recorded.  A recording that a recorder before had under
/// way goes on.
///
/// A recording that fails is a fault, which is shown, and is begun again every second; the nodes keep what is
/// not on the disk.  On a stop request it ends a recording as asked.
/// @return the epochs of all recordings
/// @throws std::invalid_argument as refuse_mistakes(), before anything begins or goes on,
///         std::runtime_error, std::system_error naming folder, file or bus
RecorderReport operate(std::stop_token stop, const OperateOptions& options);

}  // namespace roadbalance
