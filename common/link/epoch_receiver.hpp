#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "common/bus/control.hpp"
#include "common/clock/clocks.hpp"
#include "common/link/blocks.hpp"

namespace roadbalance {

/// What the record gets next, in order of sequence: a block as the node sealed it, or a gap that the host
/// declares.  A declared gap's sequence is the last one it covers; it begins behind the block before it.
using Delivery = std::variant<SealedBlock, GapBlock>;

struct ReceiverOptions {
  std::int64_t window = 2048;     ///< blocks that may arrive out of order, and that credit reaches ahead
  std::int64_t undurable = 4096;  ///< blocks received but not on the disk, before credit stops
  std::chrono::milliseconds hole_age{5};  ///< a hole this old is asked for ...
  std::int64_t newer_blocks = 3;          ///< ... or one with so many newer blocks
  std::chrono::milliseconds ask_again{20};
};

/// Where the record of a node epoch stands.
struct EpochPosition {
  std::int64_t contiguous = 0;  ///< last sequence that is in the record with all before it
  std::int64_t next_scan = 0;   ///< index of the scan that follows
  bool ended = false;           ///< end_t or a crash gap is there
};

/// Receives the blocks of one epoch of one node: orders them, finds the holes, declares what is lost.
/// A fixed window; nothing grows with the length of the drive.
class EpochReceiver {
 public:
  enum class Take { kAccepted, kDuplicate, kOutsideWindow };

  EpochReceiver(std::int32_t node, std::int64_t epoch, EpochPosition start, ReceiverOptions options);

  Take block(const SealedBlock& block, WallTime now, std::vector<Delivery>& out);
  /// The node holds base .. next - 1: reveals a lost tail, and what is gone for good.
  void heartbeat(const Heartbeat& heartbeat, WallTime now, std::vector<Delivery>& out);
  /// The node died without an end: delivers what has arrived and declares the rest.
  void crash(std::vector<Delivery>& out);
  void durable(std::int64_t sequence);

  /// Holes to ask for now; they are not given again before `ask_again`.
  std::vector<SequenceRange> missing(WallTime now);
  bool has_holes() const { return highest_ > contiguous_; }

  std::int64_t epoch() const { return epoch_; }
  std::int64_t received() const { return contiguous_; }
  std::int64_t durable() const { return durable_; }
  std::int64_t credit() const;
  bool ended() const { return ended_; }
  std::int64_t gaps() const { return gaps_; }  ///< declared here

 private:
  struct Slot {
    SealedBlock block;
    bool arrived = false;
    bool asked = false;
    WallTime noticed{};  // when we learnt that it exists
    WallTime asked_at{};
  };
  Slot& slot(std::int64_t sequence);
  void extend(std::int64_t sequence, WallTime now);
  BlockHeader next_header(std::int64_t sequence) const;
  bool declare_loss(std::vector<Delivery>& out, bool at_once);
  void deliver_contiguous(std::vector<Delivery>& out);
  void deliver(Slot& slot, std::vector<Delivery>& out);
  void lose_through(std::int64_t sequence, std::vector<Delivery>& out);

  const std::int32_t node_;
  const std::int64_t epoch_;
  const ReceiverOptions options_;
  std::vector<Slot> slots_;

  std::int64_t contiguous_;
  std::int64_t durable_;
  std::int64_t highest_;  // highest sequence known to exist, at most contiguous + window
  std::int64_t newest_arrived_;
  bool ended_;
  std::int64_t loss_through_ = 0;  // a loss up to here waits for a block that tells its scans

  std::int64_t next_scan_;
  BlockHeader last_scans_;  // of the last block with scans
  double ns_per_scan_ = 0;  // between the last two of these
  std::int64_t gaps_ = 0;
};

}  // namespace roadbalance
