#include "common/process/spsc_queue.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace roadbalance {
namespace {

TEST(SpscQueue, HoldsAsManyAsItWasMadeForInTheirOrder) {
  SpscQueue<int> queue(3);
  EXPECT_EQ(queue.front(), nullptr);
  for (int round = 0; round < 5; ++round) {  // over the end of its memory, too
    for (const int item : {1, 2, 3}) EXPECT_TRUE(queue.push(item));
    EXPECT_FALSE(queue.push(4));
    for (const int item : {1, 2, 3}) {
      ASSERT_NE(queue.front(), nullptr);
      EXPECT_EQ(*queue.front(), item);
      queue.pop();
    }
    EXPECT_EQ(queue.front(), nullptr);
  }
}

TEST(SpscQueue, LosesAndInventsNothingBetweenTwoThreads) {
  SpscQueue<int> queue(16);
  constexpr int kItems = 200'000;
  std::thread writer([&] {
    for (int item = 0; item < kItems;)
      if (queue.push(item))
        ++item;
      else
        std::this_thread::yield();
  });
  for (int item = 0; item < kItems;) {
    const int* const front = queue.front();
    if (!front) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(*front, item++);
    queue.pop();
  }
  writer.join();
  EXPECT_EQ(queue.front(), nullptr);
}

}  // namespace
}  // namespace roadbalance
