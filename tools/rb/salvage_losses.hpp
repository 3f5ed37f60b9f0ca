#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/record/record.hpp"
#include "host/recorder/verify_missing.hpp"

namespace roadbalance {

/// What of the sources was lost that no gap can stand for, since nothing tells what it was: perhaps notes, or
/// all blocks of an epoch.
class SalvageLosses {
 public:
  void damaged(std::uint64_t bytes) { bytes_ += bytes; }
  void altered_entry() { ++entries_; }
  void altered_header() { ++headers_; }
  /// An event on a block's channel, of the epoch that it says if it says one.
  void altered_block(const LogEvent& event);
  void missing_segments(std::int64_t count) { segments_ += count; }
  /// The first ones of a folder, by the retention mode.
  void deleted_segments(const std::string& folder, SegmentRun run);
  /// Where a part of the recording is that no source holds, of find_elsewhere().
  void elsewhere(const std::string& line) { listed_.push_back(line); }

  /// In words, one for each kind; none if nothing is lost.
  /// @param is_held  epochs of which blocks are here: their numbers prove which are not
  std::vector<std::string> lines(const std::function<bool(const NodeEpoch&)>& is_held) const;

 private:
  std::uint64_t bytes_ = 0;
  std::int64_t entries_ = 0, headers_ = 0, segments_ = 0;
  std::map<NodeEpoch, std::int64_t> blocks_;
  std::vector<std::string> listed_;  ///< lines
};

}  // namespace roadbalance
