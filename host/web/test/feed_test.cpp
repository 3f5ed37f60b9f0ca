#include "host/web/feed.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "common/bus/control_messages.hpp"
#include "common/bus/results.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// The kind of a channel.
std::size_t kind(const std::string& channels) {
  const auto messages = page_messages();
  const auto found = std::ranges::find_if(messages, [&](const auto& m) { return channels == m.channels; });
  EXPECT_NE(found, messages.end()) << channels;
  return static_cast<std::size_t>(found - messages.begin());
}
const std::size_t kState = kind("RB_HEARTBEAT_.*");
const std::size_t kResult = kind("RB_BALANCE");

/// The ages and first bytes of a frame's messages.
struct Entry {
  std::uint32_t age_ms;
  std::vector<std::uint8_t> bytes;
  bool operator==(const Entry&) const = default;
};
std::vector<Entry> entries(const Frame& frame) {
  const FrameBytes& bytes = *frame.bytes;
  const auto u32 = [&](std::size_t at) {
    return std::uint32_t{bytes.at(at)} << 24 | std::uint32_t{bytes.at(at + 1)} << 16 |
           std::uint32_t{bytes.at(at + 2)} << 8 | bytes.at(at + 3);
  };
  EXPECT_EQ(u32(0), kFrameMark);
  std::vector<Entry> found(u32(4));
  std::size_t at = 8;
  for (Entry& entry : found) {
    entry.age_ms = u32(at);
    const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at) + 8;
    entry.bytes = {begin, begin + u32(at + 4)};
    at += 8 + u32(at + 4);
  }
  EXPECT_EQ(at, bytes.size());
  return found;
}

class FeedTest : public testing::Test {
 protected:
  void take(std::size_t what, std::int64_t key, std::uint8_t byte) {
    feed_.take({{what, key}, {byte}}, now_);
  }

  Feed feed_;
  WallTime now_{seconds(1000)};
};

TEST_F(FeedTest, ALatePageGetsTheNewestOfEachTopicWithItsAge) {
  take(kState, 1, 10);
  take(kResult, 0, 20);
  take(kState, 1, 11);
  now_ += milliseconds(1500);
  take(kState, 2, 12);
  EXPECT_EQ(entries(feed_.since(0, now_)), (std::vector<Entry>{{1500, {11}}, {0, {12}}, {1500, {20}}}));
}

TEST_F(FeedTest, ASlowPageSkipsToTheNewest) {
  take(kState, 1, 1);
  const std::uint64_t seen = feed_.since(0, now_).revision;
  EXPECT_EQ(feed_.since(seen, now_).bytes, nullptr);
  for (std::uint8_t i = 2; i < 100; ++i) take(kState, 1, i);
  take(kState, 2, 200);
  EXPECT_EQ(entries(feed_.since(seen, now_)), (std::vector<Entry>{{0, {99}}, {0, {200}}}));
}

TEST_F(FeedTest, PagesThatAreEquallyFarShareOneFrame) {
  take(kState, 1, 1);
  EXPECT_EQ(feed_.since(0, now_).bytes, feed_.since(0, now_).bytes);
  const auto before = feed_.since(0, now_).bytes;
  take(kState, 1, 2);
  EXPECT_NE(feed_.since(0, now_).bytes, before);
}

TEST_F(FeedTest, AStateThatIsNotRepeatedIsForgottenAndAResultIsNot) {
  take(kState, 1, 1);
  take(kResult, 0, 2);
  EXPECT_EQ(entries(feed_.since(0, now_)).size(), 2U);  // a page that came before shares nothing with it
  now_ += Feed::kForget + milliseconds(1);
  feed_.forget_silent(now_);
  EXPECT_EQ(entries(feed_.since(0, now_)), (std::vector<Entry>{{3'600'001, {2}}}));
}

TEST_F(FeedTest, KeepsNoMoreTopicsThanItMay) {
  for (std::int64_t key = 0; key < 10'000; ++key) take(kState, key, 1);
  EXPECT_EQ(feed_.topics(), Feed::kMostTopics);
  take(kState, 3, 7);
  EXPECT_EQ(entries(feed_.since(0, now_)).at(3).bytes, std::vector<std::uint8_t>{7});
}

TEST_F(FeedTest, AnswersToManyAskersCrowdOutNothingAndAreSoonForgotten) {
  const auto messages = page_messages();
  const auto answers =
      static_cast<std::size_t>(std::ranges::find(messages, true, &PageMessage::is_answer) - messages.begin());
  ASSERT_LT(answers, messages.size());
  for (std::int64_t key = 0; key < 10'000; ++key) take(answers, key, 1);
  EXPECT_EQ(feed_.topics(), messages[answers].most);
  take(answers, 20'000, 7);
  EXPECT_EQ(entries(feed_.since(0, now_)).back().bytes, std::vector<std::uint8_t>{7}) << "the newest is told";
  take(kState, 1, 9);
  now_ += Feed::kForgetAnswer + milliseconds(1);
  feed_.forget_silent(now_);
  EXPECT_EQ(entries(feed_.since(0, now_)).size(), 1U);
}

TEST_F(FeedTest, WhatAPageAskedForGoesToItAlone) {
  const auto take_for = [&](std::int64_t viewer, std::uint8_t byte) {
    feed_.take({{kState, 1, viewer}, {byte}}, now_);
  };
  take_for(5, 1);
  EXPECT_EQ(feed_.since(0, now_, 5).bytes, nullptr) << "nobody asked here";
  ASSERT_TRUE(feed_.expect(5, now_));
  take_for(5, 2);
  take_for(6, 3);
  take(kState, 1, 9);
  EXPECT_EQ(entries(feed_.since(0, now_, 5)), (std::vector<Entry>{{0, {9}}, {0, {2}}}));
  EXPECT_EQ(entries(feed_.since(0, now_, 6)), (std::vector<Entry>{{0, {9}}}));
  EXPECT_EQ(entries(feed_.since(0, now_)), (std::vector<Entry>{{0, {9}}}));
}

TEST_F(FeedTest, APageThatAsksNoMoreIsForgotten) {
  ASSERT_TRUE(feed_.expect(5, now_));
  feed_.take({{kState, 1, 5}, {1}}, now_);
  now_ += Feed::kForgetViewer + milliseconds(1);
  feed_.forget_silent(now_);
  EXPECT_EQ(entries(feed_.since(0, now_, 5)).size(), 0U);
  feed_.take({{kState, 1, 5}, {1}}, now_);
  EXPECT_EQ(entries(feed_.since(0, now_, 5)).size(), 0U);
}

TEST_F(FeedTest, PagesThatAskAndTheirTopicsAreBounded) {
  for (std::size_t viewer = 1; viewer <= 2 * Feed::kMostViewers; ++viewer)
    EXPECT_EQ(feed_.expect(static_cast<std::int64_t>(viewer), now_), viewer <= Feed::kMostViewers);
  EXPECT_TRUE(feed_.expect(1, now_)) << "who is known may go on";
  for (std::int64_t key = 0; key < 10'000; ++key) feed_.take({{kState, key, 1}, {1}}, now_);
  EXPECT_EQ(entries(feed_.since(0, now_, 1)).size(), Feed::kMostTopicsOfAViewer);
}

TEST(PageMessages, TellWhomAGoodMessageIsAboutAndRefuseOthers) {
  Heartbeat beat;
  beat.node = 7;
  auto bytes = encode(beat);
  EXPECT_EQ(page_messages()[kState].key(bytes), 7);
  EXPECT_EQ(page_messages()[kResult].key(bytes), std::nullopt);
  bytes.back() ^= 1;
  EXPECT_EQ(page_messages()[kState].key(bytes), std::nullopt);

  Balance balance;
  balance.wheel = 3;
  EXPECT_EQ(page_messages()[kResult].key(encode(balance)), 3);
  balance.wheel = 4;
  EXPECT_EQ(page_messages()[kResult].key(encode(balance)), std::nullopt);
}

TEST(PageMessages, ASpectrumIsOfWhoAskedAndThatForEverybodyIsNotShown) {
  const PageMessage& spectrum = page_messages()[kind("RB_SPECTRUM")];
  SpectrumPart part{.viewer = 77, .node = 2, .channel = 3, .parts = 2};
  const auto first = spectrum.key(encode(part));
  ASSERT_TRUE(first);
  EXPECT_EQ(spectrum.viewer(encode(part)), 77);
  part.part = 1;
  EXPECT_NE(spectrum.key(encode(part)), first) << "each part is a topic";
  part.viewer = 0;
  EXPECT_EQ(spectrum.key(encode(part)), std::nullopt);
}

}  // namespace
}  // namespace roadbalance
