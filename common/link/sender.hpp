#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/link/backlog.hpp"
#include "common/types/clocks.hpp"
#include "common/types/control.hpp"

namespace roadbalance {

/// The node's half of the loss-free link, as a pure state machine: it decides which blocks to transmit and
/// which to free; sockets and clocks stay outside.  Its memory is fixed at construction: 64 kB.
///
/// Blocks go out once as far as the credit reaches; repairs come first, oldest first.  A block is not sent
/// twice within `repeat_after`.  A block is freed only when the owner calls it durable: right epoch, owner's
/// incarnation, rising ack number, durable < next.  An incarnation lower than one that was ever obeyed is
/// never obeyed again.  To a new owner everything that it has not received goes out once more.
/// Used by the ring's consumer thread only.
class Sender {
 public:
  struct Options {
    std::chrono::milliseconds repeat_after{10};
    std::chrono::milliseconds lease{700};  ///< an owner that was silent for so long may be replaced
    double blocks_per_s = 20'000;          ///< token bucket over all transmissions ...
    double burst_blocks = 64;              ///< ... and its size: what a small receive buffer holds
  };

  Sender(Backlog& backlog, std::int32_t node, std::int64_t epoch) : Sender(backlog, node, epoch, Options{}) {}
  Sender(Backlog& backlog, std::int32_t node, std::int64_t epoch, Options options);

  /// A recorder asks to own this node.  True if it does now: it did, or it has the highest incarnation so far
  /// and there is no owner or the owner's lease is over.
  bool claim(std::int64_t incarnation, WallTime now);
  /// The owner gives the node back.  False if it is not the owner.
  bool release(std::int64_t incarnation);
  /// There is an owner, and it was active within its lease: no other recorder leads the node.
  bool is_led(WallTime now) const { return owner_ != 0 && now - owner_heard_ <= options_.lease; }
  /// Incarnation obeyed; 0: none.
  std::int64_t owner() const { return owner_; }
  /// The highest incarnation ever obeyed; 0: none.
  std::int64_t highest_owner() const { return highest_owner_; }

  /// Frees what is durable, remembers what to repair.  False if refused (and counted).
  bool take(const Ack& ack, WallTime now);

  /// Sequences to transmit now, in this order; the caller sends backlog.get(sequence) for each.
  std::span<const std::int64_t> due(WallTime now);

  std::int64_t blocks_sent() const { return blocks_sent_; }          ///< repeats included
  std::int64_t blocks_repaired() const { return blocks_repaired_; }  ///< repeats
  std::int64_t acks_refused() const { return acks_refused_; }

 private:
  struct Sent {
    std::int64_t sequence = 0;
    WallTime at{};
  };
  bool is_good(const Ack& ack) const;
  bool spend_token();
  void send(std::int64_t sequence, WallTime now);
  void repair(WallTime now);
  void check() const;
  bool was_sent_lately(std::int64_t sequence, WallTime now) const;

  Backlog& backlog_;
  const std::int32_t node_;
  const std::int64_t epoch_;
  const Options options_;

  std::int64_t owner_ = 0;
  std::int64_t highest_owner_ = 0;
  WallTime owner_heard_{};
  std::int64_t ack_number_ = 0;
  std::int64_t credit_ = 0;
  std::int64_t sent_through_ = 0;  // everything up to here was sent at least once ...
  bool new_owner_ = false;         // ... to the owner before; this one has not spoken yet

  std::array<SequenceRange, kMaxMissingRanges> missing_{};  // of the newest ack, what is left to repair
  std::size_t missing_count_ = 0;
  std::size_t missing_at_ = 0;

  double tokens_;
  WallTime tokens_at_{};
  std::vector<Sent> sent_;  // [sequence % size]
  std::vector<std::int64_t> due_;

  std::int64_t blocks_sent_ = 0;
  std::int64_t blocks_repaired_ = 0;
  std::int64_t acks_refused_ = 0;
};

}  // namespace roadbalance
