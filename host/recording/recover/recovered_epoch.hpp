#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "common/link/scan_line.hpp"
#include "common/types/blocks.hpp"

namespace roadbalance {

/// Puts the blocks of one node epoch into a record, in ascending order, and declares each hole.
class RecoveredEpoch {
 public:
  using Write = std::function<void(const SealedBlock& block, std::int64_t timestamp_us)>;

  /// A gap that the old record's recorder declared: neither it nor the node had those blocks.  All of them
  /// before the first put().
  void declared(const SealedBlock& gap, std::int64_t timestamp_us);
  /// A block of the node, with a higher number than all before.
  void put(const SealedBlock& block, std::int64_t timestamp_us, const Write& write);
  /// There is no more.
  void finish(const Write& write);

 private:
  struct Timed {
    SealedBlock block;
    std::int64_t timestamp_us;
  };
  void write_gap(std::int64_t through, std::int64_t next_scan, GapCause cause, const BlockHeader* behind,
                 std::int64_t timestamp_us, const Write& write);
  GapCause cause_of_hole(std::int64_t first, std::int64_t last) const;
  void write_block(const Timed& timed, const Write& write);
  void write_waiting(std::int64_t next_scan, const Write& write);

  std::map<std::int64_t, Timed> declared_;  // by number; of a crash too
  std::vector<Timed> waiting_;              // behind a hole, for a block that shows how many scans it had
  std::int64_t last_sequence_ = 0;          // written
  std::int64_t last_put_ = 0;
  std::int64_t next_scan_ = 0;
  BlockHeader last_;  // of the last block written
  ScanLine scan_line_;
  bool ended_ = false;
};

}  // namespace roadbalance
