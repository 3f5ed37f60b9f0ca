#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>

namespace roadbalance {

/// How a record is kept.
struct StoreOptions {
  std::filesystem::path folder = {};
  /// Where recording goes on when `folder` fails; empty: nowhere.  It then holds the rest of the record, and
  /// a restart goes on there.
  std::filesystem::path fallback = {};
  /// It is known to be there: where it is not its disk is, and nothing is begun.
  bool continues = false;
  /// The least that the recorder's number in this run may be: see next_incarnation().
  std::int64_t least_incarnation = 1;
  std::uint64_t segment_bytes = std::uint64_t{64} << 20;
  std::chrono::milliseconds commit_period{200};
  std::size_t commit_bytes = std::size_t{4} << 20;  ///< a commit is due after so many, however soon
  /// Not for measuring: what is under way when the disk is full must fit; ballast_bytes of it are held by a
  /// file.
  std::int64_t reserve_bytes = std::int64_t{16} << 20;
  std::int64_t ballast_bytes = std::int64_t{4} << 20;
  /// The first samples are not kept waiting for others: somebody waits until they are on the disk.
  bool first_at_once = false;
  /// That the wall clock was set, or the computer slept, is noted: of a recording that is being made.
  bool notes_clocks = true;
  /// Retention: the oldest finished segments are deleted while there are more bytes; 0: never.
  std::int64_t keep_bytes = 0;
};

}  // namespace roadbalance
