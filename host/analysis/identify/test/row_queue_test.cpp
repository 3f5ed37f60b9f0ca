#include "host/analysis/identify/row_queue.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <deque>
#include <random>

namespace roadbalance {
namespace {

GridRows rows_at(std::int64_t index) {
  GridRows rows{};
  rows.first_index = index;
  rows.rows = 20;
  rows.counts[19][15] = static_cast<float>(index);
  return rows;
}

void expect_same(const GridRows& rows, std::int64_t index) {
  ASSERT_EQ(rows.first_index, index);
  ASSERT_EQ(rows.counts[19][15], static_cast<float>(index));
}

/// As a deque would do it, taken and put at both ends at random, now growing and now shrinking.
TEST(RowQueue, IsTheQueueThatADequeWouldBe) {
  RowQueue queue;
  std::deque<std::int64_t> expected;
  std::mt19937_64 random(3);
  std::int64_t next = 0;
  bool used_file = false;
  for (int step = 0; step < 120'000; ++step) {
    const unsigned grow = step / 20'000 % 2 == 0 ? 9 : 2;
    const auto what = random() % 12;
    if (what < grow || expected.empty()) {
      queue.push_back(rows_at(next));
      expected.push_back(next++);
    } else if (what == 11) {
      queue.pop_back();
      expected.pop_back();
    } else {
      queue.pop_front();
      expected.pop_front();
    }
    ASSERT_EQ(queue.size(), expected.size());
    ASSERT_EQ(queue.empty(), expected.empty());
    if (expected.empty()) continue;
    expect_same(queue.front(), expected.front());
    expect_same(queue.back(), expected.back());
    ASSERT_LE(queue.at_hand().size(), RowQueue::kInMemory);
    used_file = used_file || queue.uses_file();
  }
  EXPECT_TRUE(used_file);
  while (!expected.empty()) {  // and back to where time ran backwards
    expect_same(queue.back(), expected.back());
    queue.pop_back();
    expected.pop_back();
  }
  EXPECT_TRUE(queue.empty());
}

TEST(RowQueue, IsEmptyAndUsableWhenCleared) {
  RowQueue queue;
  for (int i = 0; i < 10'000; ++i) queue.push_back(rows_at(i));
  ASSERT_TRUE(queue.uses_file());
  queue.clear();
  EXPECT_TRUE(queue.empty());
  for (int i = 0; i < 10'000; ++i) queue.push_back(rows_at(2 * i));
  for (int i = 0; i < 10'000; ++i, queue.pop_front()) expect_same(queue.front(), 2 * i);
  EXPECT_TRUE(queue.empty());
}

/// A disk that takes no more costs memory, and no row.
TEST(RowQueue, LosesNothingWhereNoFileCanGrow) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  RowQueue queue;
  for (int i = 0; i < 30'000; ++i) {
    if (i == 10'000) {
      const rlimit small{4'000'000, before.rlim_max};
      ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    }
    queue.push_back(rows_at(i));
  }
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_EQ(queue.size(), 30'000U);
  for (int i = 0; i < 30'000; ++i, queue.pop_front()) expect_same(queue.front(), i);
  EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace roadbalance
