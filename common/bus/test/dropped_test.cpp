// The kernel counts the messages that it keeps from a bus.
#include <gtest/gtest.h>

#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/process_port.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using Bytes = std::vector<std::uint8_t>;

class Dropped : public ::testing::Test {
 protected:
  const std::string url_ = bus_url_on_port(process_port());
  Bus sender_{url_};
};

TEST_F(Dropped, WhatFindsNoRoomIsCounted) {
  constexpr std::int64_t kSent = 20'000;
  Bus bus(url_);
  std::int64_t heard = 0;
  bus.subscribe("RB_TEST", [&heard](std::string_view, auto) { ++heard; });
  bus.handle(milliseconds(0));
  for (int k = 0; k < kSent; ++k) ASSERT_TRUE(sender_.publish("RB_TEST", Bytes(1000)));
  while (bus.handle(milliseconds(200)) > 0) {
  }
  EXPECT_LT(heard, kSent);
  EXPECT_EQ(heard + bus.dropped(), kSent);
}

TEST_F(Dropped, ARunThatNobodyWantsIsNotOpened) {
  Bus node(url_);
  int heard = 0;
  node.subscribe("RB_ACK_2", [&heard](std::string_view, auto) { ++heard; });
  node.handle(milliseconds(0));
  sender_.gather("RB_BLOCK_");
  for (int k = 0; k < 150; ++k) ASSERT_TRUE(sender_.publish("RB_BLOCK_1_SCAN", Bytes(300)));
  ASSERT_TRUE(sender_.publish("RB_HEARTBEAT_1", Bytes(10)));
  for (int k = 0; k < 40; ++k) ASSERT_TRUE(sender_.publish("RB_BLOCK_1_EDGE", Bytes(250)));
  EXPECT_EQ(sender_.send_gathered(), 0U);
  ASSERT_TRUE(sender_.publish("RB_ACK_2", Bytes(30)));
  while (heard == 0) ASSERT_GT(node.handle(milliseconds(2000)), 0);
  EXPECT_EQ(node.dropped(), 5);  // runs of 64, 64 and 22 scans, one of 40 edges; the heartbeat
}

}  // namespace
}  // namespace roadbalance
