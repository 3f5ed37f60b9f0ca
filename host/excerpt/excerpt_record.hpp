#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string_view>

#include "common/record/journal_tally.hpp"
#include "common/record/record.hpp"

namespace roadbalance {

/// The record that is written: its segments' preamble, its journal, its manifest.
class ExcerptRecord {
 public:
  /// @throws as RecordWriter
  explicit ExcerptRecord(const std::filesystem::path& folder);

  /// What is put from here on bears this time.
  void at(std::int64_t timestamp_us) { timestamp_us_ = timestamp_us; }
  void put(std::string_view channel, std::span<const std::uint8_t> data);
  /// @param losses  of its node in its epoch so far
  void put(const SealedBlock& block, const NodeLosses& losses);
  /// Syncs, closes, lists the segments.
  void close();

 private:
  struct Open {
    std::int64_t blocks = 0;  ///< since the last entry of the journal
    NodeLosses losses = {};
  };
  void write_entry(const NodeEpoch& key, Open& open);

  const std::filesystem::path folder_;
  RecordWriter writer_;
  JournalTally journal_;
  std::map<NodeEpoch, Open> open_;
  std::int64_t timestamp_us_ = 0;
};

}  // namespace roadbalance
