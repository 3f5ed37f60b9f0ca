#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "common/link/ask_interval.hpp"
#include "common/link/scan_line.hpp"
#include "common/types/blocks.hpp"
#include "common/types/clocks.hpp"
#include "common/types/control.hpp"

namespace roadbalance {

/// The next entry of the record, in order of sequence: a block as the node sealed it, or a gap that the host
/// declares.  A declared gap's sequence is the last one it covers; it begins behind the block before it.
using Delivery = std::variant<SealedBlock, GapBlock>;

struct ReceiverOptions {
  std::int64_t window = 2048;     ///< blocks that may arrive out of order, and that credit reaches ahead
  std::int64_t undurable = 4096;  ///< blocks received but not on the disk, before credit stops
  std::chrono::milliseconds hole_age{5};      ///< a hole this old is asked for ...
  std::int64_t newer_blocks = 3;              ///< ... or one with so many newer blocks
  std::chrono::milliseconds ask_again{20};    ///< at least; twice the round trip if that is longer
  std::chrono::milliseconds repeat_after{3};  ///< every question is asked in two acks, so far apart at least
};

/// Where the record of a node epoch stands.
struct EpochPosition {
  std::int64_t contiguous = 0;  ///< last sequence that is in the record with all before it
  std::int64_t next_scan = 0;   ///< index of the scan that follows
  bool ended = false;           ///< end_t or a crash gap is there
  bool crashed = false;         ///< a crash gap: our word that it ended, not the node's
};

/// Receives the blocks of one epoch of one node: orders them, finds the holes, declares what is lost.
///
/// Memory: 40 bytes a place of the window, and 1.5 kB each once a block has come out of order (3 MB with the
/// options' window); nothing grows with the length of the drive.  No more is let in than `undurable` allows,
/// whatever a sender makes of its credit. Invariants, asserted: durable <= received <= highest known <=
/// received + window; all of them only rise.
class EpochReceiver {
 public:
  enum class Take { kAccepted, kDuplicate, kOutsideWindow };

  EpochReceiver(std::int32_t node, std::int64_t epoch, EpochPosition start, ReceiverOptions options);

  Take block(const SealedBlock& block, WallTime now, std::vector<Delivery>& out);
  /// The node holds base .. next - 1: reveals a lost tail, and what is gone for good.
  void heartbeat(const Heartbeat& heartbeat, WallTime now, std::vector<Delivery>& out);
  /// The node died without an end: delivers what has arrived and declares the rest.  Nothing is taken any
  /// more, and acks report no more than had been received without a hole: the node may only have slept.
  void crash(std::vector<Delivery>& out);
  void durable(std::int64_t sequence);

  /// False: the credit given stays as it is.
  void set_credit_open(bool open);
  /// Fills all but incarnation and number, with the holes to ask for now; they are not given again before it
  /// is time to.
  Ack acknowledge(WallTime now);
  /// The holes alone, as in acknowledge().
  std::vector<SequenceRange> missing(WallTime now);
  bool has_holes() const { return highest_ > contiguous_; }

  EpochPosition position() const;
  std::int32_t node() const { return node_; }
  std::int64_t epoch() const { return epoch_; }
  std::int64_t received() const { return contiguous_; }
  std::int64_t durable() const { return durable_; }
  std::int64_t credit() const;
  bool ended() const { return ended_; }        ///< by an end or a crash
  bool given_up() const { return given_up_; }  ///< crash() was called before its end
  std::int64_t gaps() const { return gaps_; }  ///< declared here

 private:
  struct Slot {
    WallTime noticed{};   // when we learnt that it exists
    WallTime asked_at{};  // last
    std::int32_t asks = 0;
    bool reported_twice = false;
    bool arrived = false;
  };
  Slot& slot(std::int64_t sequence);
  SealedBlock& stored(std::int64_t sequence);
  bool is_asked_now(Slot& slot, std::int64_t sequence, WallTime now);
  void answered(Slot& slot, WallTime now);
  Take repeated(const SealedBlock& block, std::vector<Delivery>& out);
  std::int64_t most() const;
  void extend(std::int64_t sequence, WallTime now);
  BlockHeader next_header(std::int64_t sequence, const BlockHeader* after) const;
  bool declare_loss(std::vector<Delivery>& out, std::optional<std::int64_t> next_scan);
  void wait_no_longer(WallTime now, std::vector<Delivery>& out);
  void deliver_contiguous(std::vector<Delivery>& out);
  void deliver(const SealedBlock& block, std::vector<Delivery>& out);
  void lose_through(std::int64_t sequence, std::vector<Delivery>& out);
  void check() const;

  const std::int32_t node_;
  const std::int64_t epoch_;
  const ReceiverOptions options_;
  std::vector<Slot> slots_;          // [sequence % window]
  std::vector<SealedBlock> blocks_;  // the same, of blocks that came out of order; none before the first
  AskInterval ask_interval_;

  std::int64_t contiguous_;
  std::int64_t durable_;
  std::int64_t highest_;  // highest sequence known to exist, at most contiguous + window
  std::int64_t newest_arrived_;
  std::int64_t credit_given_;
  bool credit_open_ = true;
  bool ended_;
  bool given_up_;
  std::int64_t received_at_crash_;
  std::int64_t loss_through_ = 0;        // a loss up to here waits for a block that shows its scans ...
  std::optional<WallTime> waits_since_;  // ... since the first heartbeat of it
  std::optional<WallTime> waited_at_;    // in vain, for the last time
  std::int64_t lost_through_ = 0;        // the last one of all that are lost

  std::int64_t next_scan_;
  ScanLine scan_line_;
  std::int64_t gaps_ = 0;
};

}  // namespace roadbalance
