#include "common/process/waking_queue.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace roadbalance {
namespace {

using std::chrono::steady_clock;

// Hundreds of thousands of times the reader sees an item before, while and after it is called.
TEST(WakingQueue, EveryItemArrivesOnceInOrderHoweverTheTwoThreadsMeet) {
  constexpr std::uint32_t kCount = 300'000;
  WakingQueue<std::uint32_t> queue(256);
  std::jthread writer([&] {
    for (std::uint32_t k = 0; k < kCount;) {
      std::uint32_t* const room = queue.room();
      if (!room) {
        std::this_thread::yield();
        continue;
      }
      *room = k++;
      queue.post();
    }
  });
  for (std::uint32_t k = 0; k < kCount; ++k) {
    ASSERT_TRUE(queue.front() || queue.wait_until(steady_clock::now() + std::chrono::seconds(60))) << k;
    ASSERT_EQ(*queue.front(), k);
    queue.pop();
  }
  EXPECT_EQ(queue.front(), nullptr);
  EXPECT_FALSE(queue.wait_until(steady_clock::now()));
}

TEST(WakingQueue, HasNoRoomForMoreThanItHolds) {
  WakingQueue<int> queue(256);
  int held = 0;
  for (; queue.room(); ++held) queue.post();
  EXPECT_EQ(held, 256);
  queue.pop();
  EXPECT_NE(queue.room(), nullptr);
}

}  // namespace
}  // namespace roadbalance
