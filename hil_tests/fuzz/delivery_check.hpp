#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <variant>

#include "common/bus/codec.hpp"
#include "common/bus/control_messages.hpp"
#include "common/link/epoch_receiver.hpp"
#include "hil_tests/fuzz/property.hpp"

namespace roadbalance::fuzz {

/// Deliveries to a recorder from each node epoch: every number once, in order, by a block or within a gap.
class DeliveryCheck {
 public:
  void take(const Delivery& delivery) {
    const auto* gap = std::get_if<GapBlock>(&delivery);
    const BlockHeader& header = gap ? gap->header : std::get<SealedBlock>(delivery).header;
    reached_.count();
    Seen& seen = seen_[{header.node, header.epoch}];
    const bool is_own = !gap || !stands_for_lost_blocks(gap->cause);
    require(!seen.ended, "nothing follows the end of an epoch");
    require(header.sequence > seen.sequence, "no number is delivered twice");
    require(!is_own || header.sequence == seen.sequence + 1, "no number is passed over");
    require(header.first_scan >= 0 && header.scans >= 0 && header.scans <= kIndexLimit, "scans are counted");
    require(!gap || is_readable(*gap), "every reader accepts a gap that is declared");
    // Blocks that its node still has are lost with the node only.
    if (gap && gap->cause == GapCause::kLostAtNode && header.sequence >= seen.base) dying_.insert(&seen);
    require(!gap || gap->cause != GapCause::kNodeCrash || header.sequence == seen.sequence + 1,
            "a crash is the next number");
    seen.sequence = header.sequence;
    seen.ended =
        gap ? gap->cause == GapCause::kNodeCrash : std::get<SealedBlock>(delivery).kind == BlockKind::kEnd;
    if (seen.ended) dying_.erase(&seen);
  }
  /// All that one message brought was taken.
  void settled() const {
    require(dying_.empty(), "only what its node said that it no longer has is lost, unless it has died");
  }

  /// Messages that the recorder has received.
  void heard(const Heartbeat& beat) {
    std::int64_t& base = seen_[{beat.node, beat.epoch}].base;
    base = std::max(base, beat.base);
  }

  std::int64_t delivered(std::int32_t node, std::int64_t epoch) const {
    const auto found = seen_.find({node, epoch});
    return found == seen_.end() ? 0 : found->second.sequence;
  }
  void recovered(std::int32_t node, std::int64_t epoch, std::int64_t sequence) {
    seen_[{node, epoch}].sequence = sequence;
  }

 private:
  static bool is_readable(const GapBlock& gap) {
    SealedBlock sealed, read;
    seal(gap, sealed);
    return accept(sealed.bytes(), read) == Refusal::kNone;
  }

  static inline Reached reached_{"a delivery"};
  struct Seen {
    std::int64_t sequence = 0;
    std::int64_t base = 0;  // the highest heard
    bool ended = false;
  };
  std::map<std::pair<std::int32_t, std::int64_t>, Seen> seen_;
  std::set<const Seen*> dying_;  // a crash must follow before the next message
};

}  // namespace roadbalance::fuzz
