#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/bus/control_messages.hpp"

namespace roadbalance::test {

/// A recorder in little: claims the node, starts it, keeps blocks in memory and loses every third datagram
/// the first time it sees it, so that repairs are needed.
class LittleRecorder {
 public:
  LittleRecorder(const std::string& url, std::int32_t node) : bus_(url), node_(node) {
    bus_.subscribe("RB_BLOCK_.*",
                   [this](std::string_view, std::span<const std::uint8_t> bytes) { take(bytes); });
    bus_.subscribe(heartbeat_channel(node_), [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto beat = decode_heartbeat(bytes)) heard(*beat);
    });
    bus_.subscribe(reply_channel(node_), [this](std::string_view, std::span<const std::uint8_t> bytes) {
      if (const auto reply = decode_reply(bytes)) replies[reply->request] = *reply;
    });
  }

  /// Until the epoch is complete.
  void run(std::stop_token stop) {
    while (!stop.stop_requested() && !(end > 0 && received_through() == end && last.base > end)) {
      bus_.handle(std::chrono::milliseconds(20));
      if (last.epoch == 0) continue;
      if (!replies.contains(1)) say(1, Verb::kClaim);
      if (replies.contains(1) && !replies.contains(2)) say(2, Verb::kStart);
      if (takes_nothing || (slow && most_spooled <= 500)) continue;
      acknowledge();
    }
  }

  bool slow = false;           ///< takes nothing before the node had to move blocks to its disk
  bool takes_nothing = false;  ///< at all
  std::function<void()> on_all_sealed = [] {};
  std::int64_t most_spooled = 0;

  std::map<std::int64_t, SealedBlock> blocks;
  std::map<std::int64_t, Reply> replies;
  std::int64_t end = 0;
  Heartbeat last;

 private:
  void say(std::int64_t request, Verb verb) {
    bus_.publish(command_channel(node_),
                 encode(Command{.node = node_, .request = request, .incarnation = 1, .verb = verb}));
  }
  void heard(const Heartbeat& beat) {
    last = beat;
    most_spooled = std::max(most_spooled, beat.spool_used);
    if (beat.state == NodeState::kEnded) on_all_sealed();
  }
  void take(std::span<const std::uint8_t> bytes) {
    SealedBlock block;
    ASSERT_EQ(accept(bytes, block), Refusal::kNone);
    const std::int64_t sequence = block.header.sequence;
    if (sequence % 3 == 0 && dropped_.insert({sequence, true}).second) return;
    if (block.kind == BlockKind::kEnd) end = sequence;
    blocks.emplace(sequence, block);
  }
  std::int64_t received_through() const {
    std::int64_t through = 0;
    for (auto it = blocks.find(1); it != blocks.end() && it->first == through + 1; ++it) ++through;
    return through;
  }
  void acknowledge() {
    Ack ack;
    ack.node = node_;
    ack.epoch = last.epoch;
    ack.incarnation = 1;
    ack.number = ++number_;
    ack.received = ack.durable = received_through();
    ack.credit = ack.received + 2000;
    std::int64_t next = ack.received + 1;
    for (auto it = blocks.upper_bound(ack.received);
         it != blocks.end() && ack.missing.size() < kMaxMissingRanges; ++it) {
      if (it->first > next) ack.missing.push_back({next, it->first - 1});
      next = it->first + 1;
    }
    if (next < last.next && ack.missing.size() < kMaxMissingRanges)
      ack.missing.push_back({next, last.next - 1});
    bus_.publish(ack_channel(node_), encode(ack));
  }

  Bus bus_;
  const std::int32_t node_;
  std::map<std::int64_t, bool> dropped_;
  std::int64_t number_ = 0;
};

}  // namespace roadbalance::test
