#include "firmware/life_watch.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(LifeWatch, ANodeLivesWhileBothTurn) {
  AcquireLink link;
  LifeWatch watch(link);
  EXPECT_FALSE(watch.both_turned()) << "nobody has begun";
  ++link.uplink_turns;
  EXPECT_FALSE(watch.both_turned()) << "the device is not read";
  ++link.acquire_turns;
  EXPECT_TRUE(watch.both_turned());
  EXPECT_FALSE(watch.both_turned()) << "nobody has turned since";
  ++link.acquire_turns;
  EXPECT_FALSE(watch.both_turned()) << "nothing is sent";
  ++link.uplink_turns;
  EXPECT_TRUE(watch.both_turned());
}

TEST(LifeWatch, WhenTheDeviceHasEndedSendingTheRestIsLife) {
  for (const NodeState last : {NodeState::kEnded, NodeState::kFailed}) {
    AcquireLink link;
    LifeWatch watch(link);
    link.state = last;
    EXPECT_FALSE(watch.both_turned());
    ++link.uplink_turns;
    EXPECT_TRUE(watch.both_turned());
  }
}

}  // namespace
}  // namespace roadbalance
