#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/record/log_event.hpp"
#include "common/record/recorded_clocks.hpp"
#include "host/recording/verify/verify_missing.hpp"

namespace roadbalance {

/// Losses of the sources that no gap can stand for, since their content is unknown: perhaps notes, or all
/// blocks of an epoch.
class RecoveredLosses {
 public:
  void damaged(std::uint64_t bytes) { bytes_ += bytes; }
  void altered_entry() { ++entries_; }
  void altered_header() { ++headers_; }
  /// An event on a block's channel, of the epoch that it names, if it names one.
  void altered_block(const LogEvent& event);
  void missing_segments(std::int64_t count) { segments_ += count; }
  /// The first segments of a folder, deleted by the retention mode.
  void deleted_segments(const std::string& folder, SegmentRun run);
  /// A part of the recording that no source holds, as find_elsewhere() reports it.
  void elsewhere(const std::string& line) { listed_.push_back(line); }

  /// In words, one for each kind; none if nothing is lost.
  /// @param is_held  epochs of which blocks are here: their numbers prove which blocks are missing
  std::vector<std::string> lines(const std::function<bool(const NodeEpoch&)>& is_held) const;

 private:
  std::uint64_t bytes_ = 0;
  std::int64_t entries_ = 0, headers_ = 0, segments_ = 0;
  std::map<NodeEpoch, std::int64_t> blocks_;
  std::vector<std::string> listed_;  ///< lines
};

}  // namespace roadbalance
