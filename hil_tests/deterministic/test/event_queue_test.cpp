#include "hil_tests/deterministic/event_queue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace roadbalance::test {
namespace {

// Against a sorted list: events come and go, and many are at one instant.
TEST(EventQueue, GivesEventsByTimeAndOfOneInstantAsTheyWereAdded) {
  std::mt19937 random(1);
  EventQueue queue;
  std::vector<Event> sorted;
  std::uint32_t number = 0;
  const auto take = [&] {
    const Event event = queue.take();
    ASSERT_EQ(event.at_ns, sorted.front().at_ns);
    ASSERT_EQ(event.what, sorted.front().what);
    sorted.erase(sorted.begin());
  };
  for (int step = 0; step < 20'000; ++step) {
    const bool grows = step / 2'000 % 2 == 0;
    if (!sorted.empty() && random() % 10 < (grows ? 4 : 6)) {
      take();
      continue;
    }
    const Event event{.at_ns = static_cast<std::int64_t>(random() % 50), .what = number++};
    queue.add(event.at_ns, Event::Kind::kDevice, 0, event.what);
    const auto behind = std::upper_bound(sorted.begin(), sorted.end(), event,
                                         [](const Event& a, const Event& b) { return a.at_ns < b.at_ns; });
    sorted.insert(behind, event);
    ASSERT_FALSE(queue.empty());
  }
  while (!sorted.empty()) take();
  EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace roadbalance::test
