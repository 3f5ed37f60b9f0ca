#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/recording.hpp"

namespace roadbalance {

/// A recording and where it is.
struct ListedRecording {
  RecordingReceipt receipt;
  std::filesystem::path folder;
};

/// The recordings in a folder, and among the results of jobs, and what is known of them.
///
/// A recording is a folder that holds a segment.  It grows while a segment of it has changed within kQuiet;
/// then nothing is read, for the disk is the recorder's.  What has changed since its receipt is unread again.
/// A result appears whole and never grows; one that has the name of a recording in the folder is told with
/// kOfResults behind its name.
class RecordingsList {
 public:
  static constexpr std::chrono::seconds kQuiet{5};
  using FileTime = std::filesystem::file_time_type;

  static constexpr const char* kOfResults = " (result)";

  /// @param results  of jobs; empty: there are none
  explicit RecordingsList(std::filesystem::path folder, std::filesystem::path results = {})
      : folder_(std::move(folder)), results_(std::move(results)) {}

  /// Looks what is there; newest first, at most kMostRecordings.  A folder that is not there has none.
  void look(FileTime now);

  /// Whose receipt is wanted next; nothing while one grows, or if all are there.
  std::optional<std::filesystem::path> unread_one();

  /// One of them is being written.
  bool grows() const;

  /// The receipt of a recording by its name and place; one that was written to since it was wanted is wanted
  /// again.
  void take(RecordingReceipt receipt);

  std::vector<ListedRecording> listed() const;

  /// Numbered; of none a single one without a name.
  std::vector<RecordingReceipt> told() const;

 private:
  struct Entry {
    FileTime changed{};
    std::filesystem::path folder{};
    RecordingReceipt receipt;
    std::optional<FileTime> wanted{};  ///< it was in this state when its receipt was asked for
    std::optional<FileTime> read{};    ///< it was in this state when its receipt was made
    bool grows = false;
  };

  void look_in(const std::filesystem::path& place, bool is_results, FileTime now,
               std::map<std::string, Entry>& found);

  std::filesystem::path folder_, results_;
  std::map<std::string, Entry> entry_;
  std::vector<std::string> newest_first_;
};

}  // namespace roadbalance
