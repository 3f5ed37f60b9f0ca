#include "common/process/realtime.hpp"

#include <thread>

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

namespace roadbalance {
namespace {

bool says(const std::vector<std::string>& refused, const std::string& word) {
  for (const auto& text : refused)
    if (text.find(word) != std::string::npos) return true;
  return false;
}

// Whether the machine grants it is not ours to decide; that the answer is true can be checked.
TEST(Realtime, SaysExactlyWhatWasRefused) {
  std::thread([] {
    const auto refused = enter_realtime(10);
    int policy = SCHED_OTHER;
    sched_param parameter{};
    ASSERT_EQ(pthread_getschedparam(pthread_self(), &policy, &parameter), 0);
    EXPECT_EQ(policy != SCHED_FIFO, says(refused, "real-time priority 10"));
    if (policy == SCHED_FIFO) {
      EXPECT_EQ(parameter.sched_priority, 10);
    }
  }).join();
}

TEST(Realtime, IsLeftForAnOrdinaryThreadAndCanBeEnteredAgain) {
  std::thread([] {
    const auto refused = enter_realtime(10);
    leave_realtime();
    int policy = SCHED_FIFO;
    sched_param parameter{};
    ASSERT_EQ(pthread_getschedparam(pthread_self(), &policy, &parameter), 0);
    EXPECT_EQ(policy, SCHED_OTHER);
    EXPECT_EQ(enter_realtime(10), refused);
  }).join();
}

TEST(Realtime, RefusesAPriorityThatIsNone) {
  std::thread([] {
    const auto refused = enter_realtime(1'000);
    EXPECT_TRUE(says(refused, "real-time priority 1000"));
    EXPECT_TRUE(says(refused, "\"rb doctor\" says how"));
  }).join();
}

}  // namespace
}  // namespace roadbalance
