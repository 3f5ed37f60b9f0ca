#include "firmware/node_link.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "common/bus/bus.hpp"
#include "common/link/ring.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
constexpr std::int32_t kNode = 3;

struct Rig {
  int heartbeats_in(WallClock::duration time) {
    int count = 0;
    const WallTime end = now + time;
    for (; now < end; now += 1ms)
      link.turn(now, [&](const std::string& channel, std::span<const std::uint8_t>) {
        count += channel == heartbeat_channel(kNode);
        return true;
      });
    return count;
  }
  void seal_one() {
    ring.claim()->header.sequence = ring.next();
    ring.commit();
  }

  Ring ring{100 * sizeof(SealedBlock)};
  Backlog backlog{ring};
  std::unique_ptr<PreviewSlot> preview = std::make_unique<PreviewSlot>();
  AcquireLink acquire;
  VehicleChange vehicle{"", false};
  NodeLink link{kNode, 77, backlog, *preview, acquire, vehicle};
  WallTime now{1h};
};

TEST(NodeLink, SaysTenTimesASecondThatItLives) {
  Rig rig;
  EXPECT_EQ(rig.heartbeats_in(1s), 10);
}

// No recorder has given credit: only heartbeats can show it that there is something.
TEST(NodeLink, SaysItMoreOftenWhileBlocksWaitAndNoneGoesOut) {
  Rig rig;
  static_cast<void>(rig.heartbeats_in(1s));
  rig.seal_one();
  EXPECT_EQ(rig.heartbeats_in(1s), 40);
}

}  // namespace
}  // namespace roadbalance
