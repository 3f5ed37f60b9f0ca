#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/recording.hpp"

namespace roadbalance {

/// A recording and its folder.
struct ListedRecording {
  RecordingSummary summary;
  std::filesystem::path folder;
};

/// The recordings in a folder, and among the results of jobs, with their summaries.
///
/// A recording is a folder that holds a segment.  It grows while one of its segments has changed within
/// kQuiet and a recorder has locked it (a copy is not): then nothing is read, since the disk is the
/// recorder's.  A recording that changes after its summary is unread again.  A result appears complete and
/// never grows; one with the name of a recording in the folder is listed with kOfResults behind its name.
class RecordingsList {
 public:
  static constexpr std::chrono::seconds kQuiet{5};
  using FileTime = std::filesystem::file_time_type;

  static constexpr const char* kOfResults = " (result)";

  /// @param results  of jobs; empty: there are none
  explicit RecordingsList(std::filesystem::path folder, std::filesystem::path results = {})
      : folder_(std::move(folder)), results_(std::move(results)) {}

  /// Looks for recordings; keeps the newest kMostRecordings, newest first.  A missing folder has none.
  void look(FileTime now);

  /// The folder of the recording to be read next; nothing while one grows, or if all are read.
  std::optional<std::filesystem::path> unread_one();

  /// One recording is being written.
  bool grows() const;

  /// Takes the summary of a recording, found by name and place; a recording that was written to since it was
  /// asked for remains unread.
  void take(RecordingSummary summary);

  std::vector<ListedRecording> listed() const;

  /// The summaries as messages, numbered; without any recording a single one without a name.
  std::vector<RecordingSummary> reported() const;

 private:
  struct Entry {
    FileTime changed{};
    std::filesystem::path folder{};
    RecordingSummary summary;
    std::optional<FileTime> wanted{};  ///< time of the last change when its summary was asked for
    std::optional<FileTime> read{};    ///< time of the last change when its summary was made
    bool grows = false;
  };

  void look_in(const std::filesystem::path& place, bool is_results, FileTime now,
               std::map<std::string, Entry>& found);

  std::filesystem::path folder_, results_;
  std::map<std::string, Entry> entry_;
  std::vector<std::string> newest_first_;
};

}  // namespace roadbalance
