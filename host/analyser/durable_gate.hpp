#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>

#include "common/bus/control.hpp"
#include "common/clock/clocks.hpp"

namespace roadbalance {

/// Knows from the recorder's acknowledgements which blocks are on the disk for good.
class DurableGate {
 public:
  /// The recorder acknowledges five times a second while it lives.
  static constexpr std::chrono::seconds kSilence{3};

  /// @param now  a recorder never heard counts as silent this long after
  explicit DurableGate(WallTime now) : heard_(now) {}

  void acknowledge(const Ack& ack, WallTime now) {
    heard_ = now;
    auto& durable = durable_[{ack.node, ack.epoch}];
    if (ack.durable > durable) durable = ack.durable;
  }

  bool passes(const BlockHeader& header, WallTime now) const {
    if (header.sequence == 0) return true;  // the recorder's own, repeated in each segment
    const auto found = durable_.find({header.node, header.epoch});
    return (found != durable_.end() && header.sequence <= found->second) || now - heard_ > kSilence;
  }

 private:
  std::map<std::pair<std::int32_t, std::int64_t>, std::int64_t> durable_;
  WallTime heard_;
};

}  // namespace roadbalance
