#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/recording.hpp"

namespace roadbalance {

/// The recordings in a folder and what is known of them.
///
/// A recording is a folder that holds a segment.  It grows while a segment of it has changed within kQuiet;
/// then nothing is read, for the disk is the recorder's.  What has changed since its receipt is unread again.
class RecordingsList {
 public:
  static constexpr std::chrono::seconds kQuiet{5};
  using FileTime = std::filesystem::file_time_type;

  explicit RecordingsList(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Looks what is there; newest first, at most kMostRecordings.  A folder that is not there has none.
  void look(FileTime now);

  /// Whose receipt is wanted next; nothing while one grows, or if all are there.
  std::optional<std::filesystem::path> unread_one();

  /// One of them is being written.
  bool grows() const;

  /// A receipt of a recording of that name; one that was written to since it was wanted is wanted again.
  void take(RecordingReceipt receipt);

  /// Numbered; of none a single one without a name.
  std::vector<RecordingReceipt> told() const;

 private:
  struct Entry {
    FileTime changed{};
    RecordingReceipt receipt;
    std::optional<FileTime> wanted{};  ///< it was in this state when its receipt was asked for
    std::optional<FileTime> read{};    ///< it was in this state when its receipt was made
    bool grows = false;
  };

  std::filesystem::path folder_;
  std::map<std::string, Entry> entry_;
  std::vector<std::string> newest_first_;
};

}  // namespace roadbalance
