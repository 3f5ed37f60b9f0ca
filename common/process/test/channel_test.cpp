#include "common/process/channel.hpp"

#include <chrono>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using std::chrono_literals::operator""s;

template <typename T>
void destroy(T end) {
  (void)end;
}

TEST(Channel, DeliversInOrderAndWhatIsLeftAfterTheWriterIsGone) {
  auto [out, in] = make_channel<int>(8);
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(out.send(k));
  destroy(std::move(out));
  EXPECT_FALSE(in.finished());
  for (int k = 0; k < 5; ++k) EXPECT_EQ(in.receive(), k);
  EXPECT_TRUE(in.finished());
  EXPECT_EQ(in.receive(), std::nullopt);
  EXPECT_EQ(in.receive_for(0s), std::nullopt);
}

TEST(Channel, TellsTheWriterThatTheReaderIsGone) {
  auto [out, in] = make_channel<int>(8);
  EXPECT_TRUE(out.send(1));
  destroy(std::move(in));
  EXPECT_FALSE(out.send(2));
  EXPECT_FALSE(out.try_send(3));
}

TEST(Channel, HoldsNoMoreThanItsCapacity) {
  auto [out, in] = make_channel<int>(3);
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(out.try_send(k));
  EXPECT_FALSE(out.try_send(3));
  EXPECT_EQ(in.receive(), 0);
  EXPECT_TRUE(out.try_send(4));
  EXPECT_FALSE(out.try_send(5));
}

TEST(Channel, GivesUpWaitingForNothing) {
  auto [out, in] = make_channel<int>(1);
  EXPECT_EQ(in.receive_for(std::chrono::milliseconds(1)), std::nullopt);
  EXPECT_FALSE(in.finished());
  EXPECT_TRUE(out.send(7));
  EXPECT_EQ(in.receive_for(std::chrono::milliseconds(1)), 7);
}

TEST(Channel, MovesValuesThatCannotBeCopied) {
  auto [out, in] = make_channel<std::unique_ptr<int>>(1);
  EXPECT_TRUE(out.send(std::make_unique<int>(9)));
  EXPECT_EQ(**in.receive(), 9);
}

TEST(Channel, CarriesEveryValueBetweenTwoThreads) {
  auto [out, in] = make_channel<int>(4);
  constexpr int kValues = 20'000;
  std::thread writer([end = std::move(out)]() mutable {
    for (int k = 0; k < kValues; ++k) ASSERT_TRUE(end.send(k));
    destroy(std::move(end));
  });
  int expected = 0;
  while (const auto value = in.receive()) ASSERT_EQ(*value, expected++);
  EXPECT_EQ(expected, kValues);
  writer.join();
}

TEST(Channel, WakesAWriterThatWaitsForRoomWhenTheReaderGoes) {
  auto [out, in] = make_channel<int>(1);
  ASSERT_TRUE(out.send(1));
  bool taken = true;
  std::thread writer([&taken, end = std::move(out)]() mutable { taken = end.send(2); });
  destroy(std::move(in));
  writer.join();
  EXPECT_FALSE(taken);
}

TEST(Channel, ClosesTheOldOneWhenAnEndIsAssigned) {
  auto [out, in] = make_channel<int>(1);
  auto [other_out, other_in] = make_channel<int>(1);
  out = std::move(other_out);
  EXPECT_EQ(in.receive(), std::nullopt);
  EXPECT_TRUE(out.send(5));
  EXPECT_EQ(other_in.receive(), 5);
}

}  // namespace
}  // namespace roadbalance
