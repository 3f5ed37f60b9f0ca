#include "common/bus/message_run.hpp"

#include <gtest/gtest.h>
#include <lcm/lcm.h>

#include <functional>
#include <memory>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/process_port.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using Bytes = std::vector<std::uint8_t>;
using Heard = std::vector<std::pair<std::string, Bytes>>;

/// So many bytes, alike in no two places.
Bytes numbered(std::size_t size, int number) {
  Bytes bytes(size);
  std::iota(bytes.begin(), bytes.end(), static_cast<std::uint8_t>(number));
  return bytes;
}

/// All that a bus hears until "LAST".
Heard heard_by(Bus& bus, Heard& heard) {
  while (heard.empty() || heard.back().first != "LAST") EXPECT_GT(bus.handle(milliseconds(2000)), 0);
  heard.pop_back();
  return heard;
}

void keep(Bus& bus, const std::string& channels, Heard& heard) {
  bus.subscribe(channels, [&heard](std::string_view channel, std::span<const std::uint8_t> bytes) {
    heard.emplace_back(channel, Bytes(bytes.begin(), bytes.end()));
  });
}

TEST(MessageRun, TakesWhatIsAlikeAsLongAsThereIsRoom) {
  MessageRun run({.port = static_cast<std::uint16_t>(process_port(1))});
  EXPECT_TRUE(run.add("A", numbered(100, 1)));
  EXPECT_FALSE(run.add("B", numbered(100, 2)));
  EXPECT_FALSE(run.add("A", numbered(99, 2)));
  EXPECT_TRUE(run.add("A", numbered(100, 2)));
  for (int k = 2; k < 64; ++k) ASSERT_TRUE(run.add("A", numbered(100, 3)));
  EXPECT_FALSE(run.add("A", numbered(100, 3)));  // no more by one call
  EXPECT_EQ(run.send(), 0U);
  int long_ones = 0;
  while (run.add("B", numbered(1400, 4))) ++long_ones;
  EXPECT_EQ(long_ones, 65'507 / (8 + 2 + 1400));  // what a datagram of IPv4 may hold
  EXPECT_EQ(run.send(), 0U);
  EXPECT_FALSE(run.add(std::string(64, 'C'), numbered(1, 5)));  // no channel of LCM
  EXPECT_FALSE(run.add("C", Bytes(65'507)));
}

class Gathered : public ::testing::Test {
 protected:
  /// Blocks of two channels, of two lengths, more than one call takes; something else between them.
  void send() {
    sender_.gather("RB_BLOCK_");
    for (int k = 0; k < 150; ++k) publish("RB_BLOCK_1_SCAN", numbered(300, k));
    publish("RB_HEARTBEAT_1", numbered(10, 0));
    for (int k = 0; k < 3; ++k) publish("RB_BLOCK_1_SCAN", numbered(300, k));
    publish("RB_BLOCK_1_EDGE", numbered(20, 7));
    for (int k = 0; k < 40; ++k) publish("RB_BLOCK_1_EDGE", numbered(250, k));
    publish("RB_ACK_2", numbered(30, 9));
    EXPECT_EQ(sender_.send_gathered(), 0U);
    ASSERT_TRUE(sender_.publish("LAST", {}));
  }
  void publish(const std::string& channel, const Bytes& bytes) {
    ASSERT_TRUE(sender_.publish(channel, bytes));
    sent_.emplace_back(channel, bytes);
  }
  Heard sent_on(const std::set<std::string>& channels) const {
    Heard some;
    for (const auto& one : sent_)
      if (channels.contains(one.first)) some.push_back(one);
    return some;
  }

  const std::string url_ = bus_url_on_port(process_port(2));
  Bus sender_{url_};
  Heard sent_;
};

// A run has a socket of its own, and the order of two sockets is that of their calls on one machine.
TEST_F(Gathered, EveryKindOfHearerHearsAllOfItInItsOrder) {
  Bus::Options all, ahead;
  all.hears_all = true;
  ahead.ahead_bytes = 1 << 20;
  Bus plain(url_), whole(url_, all), reading(url_, ahead);
  Heard by_plain, by_whole, by_reading;
  keep(plain, ".*", by_plain);
  keep(whole, ".*", by_whole);
  keep(reading, ".*", by_reading);
  for (Bus* bus : {&plain, &whole, &reading}) bus->handle(milliseconds(0));  // they listen
  send();
  EXPECT_EQ(heard_by(plain, by_plain), sent_);
  EXPECT_EQ(heard_by(whole, by_whole), sent_);
  EXPECT_EQ(heard_by(reading, by_reading), sent_);
  for (const Bus* bus : {&plain, &whole, &reading}) EXPECT_EQ(bus->dropped(), 0);
}

TEST_F(Gathered, WhoWantsSomeOfItHearsThat) {
  Bus node(url_), edges(url_);
  Heard by_node, by_edges;
  for (const char* channel : {"RB_ACK_2", "LAST"}) keep(node, channel, by_node);
  for (const char* channel : {"RB_BLOCK_1_EDGE", "LAST"}) keep(edges, channel, by_edges);
  node.handle(milliseconds(0));
  edges.handle(milliseconds(0));
  send();
  EXPECT_EQ(heard_by(node, by_node), sent_on({"RB_ACK_2"}));
  EXPECT_EQ(heard_by(edges, by_edges), sent_on({"RB_BLOCK_1_EDGE"}));
}

/// All that a program with nothing but LCM hears until "LAST".
Heard heard_by_lcm(const std::string& url, const std::function<void()>& send) {
  const std::string with_room = url + "&recv_buf_size=" + std::to_string(kReceiveBufferBytes);
  const std::unique_ptr<lcm_t, decltype(&lcm_destroy)> lcm(lcm_create(with_room.c_str()), &lcm_destroy);
  Heard heard;
  lcm_subscription_t* const all = lcm_subscribe(
      lcm.get(), ".*",
      [](const lcm_recv_buf_t* message, const char* channel, void* to) {
        const auto* const bytes = static_cast<const std::uint8_t*>(message->data);
        static_cast<Heard*>(to)->emplace_back(channel, Bytes(bytes, bytes + message->data_size));
      },
      &heard);
  lcm_subscription_set_queue_capacity(all, 0);
  send();
  while ((heard.empty() || heard.back().first != "LAST") && lcm_handle_timeout(lcm.get(), 2000) > 0) {
  }
  if (!heard.empty()) heard.pop_back();
  return heard;
}

TEST_F(Gathered, LcmItselfHearsEachMessageOfARun) {
  EXPECT_EQ(heard_by_lcm(url_, [this] { send(); }), sent_);
}

// Longer than the datagrams of a network, but for loopback: each goes by itself, in pieces that IP puts
// together.
TEST_F(Gathered, WhatIsTooLongForTheNetworkGoesAllTheSame) {
  const Heard heard = heard_by_lcm(url_, [this] {
    sender_.gather("RB_BLOCK_");
    for (int k = 0; k < 4; ++k) publish("RB_BLOCK_1_SCAN", numbered(30'000, k));
    EXPECT_EQ(sender_.send_gathered(), 0U);
    ASSERT_TRUE(sender_.publish("LAST", {}));
  });
  EXPECT_EQ(heard, sent_);
}

}  // namespace
}  // namespace roadbalance
