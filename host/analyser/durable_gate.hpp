#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <utility>

#include "common/bus/control_messages.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// Keeps, by the recorder's acknowledgements, which blocks are on the disk for good.
class DurableGate {
 public:
  /// The recorder acknowledges a living epoch five times a second.  One that it has not acknowledged for this
  /// long is closed, or the recorder is gone: what the record holds of it is all there will be.
  static constexpr std::chrono::seconds kSilence{3};

  void acknowledge(const Ack& ack, WallTime now) {
    Epoch& epoch = epoch_of(ack.node, ack.epoch, now);
    epoch.heard = now;
    if (ack.durable > epoch.durable) epoch.durable = ack.durable;
  }

  bool passes(const BlockHeader& header, WallTime now) {
    const Epoch& epoch = epoch_of(header.node, header.epoch, now);
    return header.sequence <= epoch.durable || now - epoch.heard > kSilence;
  }

 private:
  struct Epoch {
    std::int64_t durable;
    WallTime heard;  ///< last acknowledged, or first asked for
  };
  Epoch& epoch_of(std::int32_t node, std::int64_t epoch, WallTime now) {
    return epochs_.try_emplace({node, epoch}, Epoch{0, now}).first->second;
  }

  std::map<std::pair<std::int32_t, std::int64_t>, Epoch> epochs_;
};

}  // namespace roadbalance
