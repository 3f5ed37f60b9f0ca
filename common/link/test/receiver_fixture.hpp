#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "common/bus/codec.hpp"
#include "common/link/receiver.hpp"

namespace roadbalance::test {

using namespace std::chrono_literals;
constexpr std::int64_t kEpoch = 9;
constexpr WallTime kStart{std::chrono::hours(1)};

inline SealedBlock scans(std::int64_t sequence, std::int64_t epoch = kEpoch) {
  ScanBlock block;
  block.header = {.node = 1,
                  .epoch = epoch,
                  .sequence = sequence,
                  .first_scan = 20 * (sequence - 1),
                  .scans = 20,
                  .time_ns = 10'000'000 * (sequence - 1)};
  block.period_ps = 500'000'000;
  SealedBlock sealed;
  seal(block, sealed);
  return sealed;
}

inline Heartbeat beat(std::int64_t base, std::int64_t next, std::int64_t epoch = kEpoch) {
  return {.node = 1, .epoch = epoch, .base = base, .next = next, .state = NodeState::kStarted};
}

/// A receiver, and what it delivered.
class ReceiverFixture : public ::testing::Test {
 protected:
  void take(const Heartbeat& heartbeat, WallTime at = kStart) { receiver.take(heartbeat, at, out); }
  void take(const SealedBlock& block, WallTime at = kStart) { receiver.take(block, at, out); }
  std::vector<std::int64_t> sequences() const {
    std::vector<std::int64_t> all;
    for (const auto& delivery : out)
      all.push_back(std::visit([](const auto& block) { return block.header.sequence; }, delivery));
    return all;
  }
  Ack ack_at(WallTime at) {
    const auto acks = receiver.due(at);
    EXPECT_EQ(acks.size(), 1u);
    return acks.empty() ? Ack{} : acks.front();
  }

  Receiver receiver{1};
  std::vector<Delivery> out;
};

using Sequences = std::vector<std::int64_t>;

}  // namespace roadbalance::test
