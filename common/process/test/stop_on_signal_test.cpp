#include "common/process/stop_on_signal.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <condition_variable>
#include <mutex>

namespace roadbalance {
namespace {

void expect_stop(const std::stop_token& token) {
  std::mutex mutex;
  std::condition_variable_any told;
  std::unique_lock lock(mutex);
  told.wait(lock, token, [] { return false; });  // for ever, if nobody asks
  EXPECT_TRUE(token.stop_requested());
}

TEST(StopOnSignal, AsksForAStopWhereTheProcessIsToldToEnd) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const StopOnSignal signals;
    EXPECT_FALSE(signals.token().stop_requested());
    ASSERT_EQ(kill(getpid(), signal), 0);
    expect_stop(signals.token());
  }
}

TEST(StopOnSignal, EndsWithoutASignalAndLeavesNone) {
  for (int k = 0; k < 1000; ++k) EXPECT_FALSE(StopOnSignal().token().stop_requested());
  sigset_t pending;
  ASSERT_EQ(sigpending(&pending), 0);
  EXPECT_FALSE(sigismember(&pending, SIGTERM));
  const StopOnSignal still_works;
  ASSERT_EQ(kill(getpid(), SIGTERM), 0);
  expect_stop(still_works.token());
}

}  // namespace
}  // namespace roadbalance
