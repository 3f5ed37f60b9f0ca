#pragma once

#include <filesystem>
#include <thread>

namespace roadbalance {

/// Shows on a terminal how far a command has come that goes through a recording a known number of times, by
/// the bytes that the system has counted as read by this process.
class ReadingProgress {
 public:
  /// @param passes  how often the recording is read from begin to end
  ReadingProgress(const std::filesystem::path& recording, double passes);

 private:
  std::jthread watch_;  ///< ends with this
};

}  // namespace roadbalance
