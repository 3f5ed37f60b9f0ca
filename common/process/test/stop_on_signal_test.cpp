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
  told.wait(lock, token, [] { return false; });  // for ever, unless asked to stop
  EXPECT_TRUE(token.stop_requested());
}

TEST(StopOnSignal, AsksForAStopWhereTheProcessIsToldToEnd) {
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    const StopOnSignal signals;
    EXPECT_FALSE(signals.token().stop_requested());
    ASSERT_EQ(kill(getpid(), signal), 0);
    expect_stop(signals.token());
  }
}

TEST(StopOnSignal, LeavesAHangUpIgnoredWhereItWas) {
  const auto before = std::signal(SIGHUP, SIG_IGN);
  sigset_t hang_up;
  sigemptyset(&hang_up);
  sigaddset(&hang_up, SIGHUP);
  pthread_sigmask(SIG_UNBLOCK, &hang_up, nullptr);  // as in a program that has just begun
  {
    const StopOnSignal signals;
    ASSERT_EQ(kill(getpid(), SIGHUP), 0);
    ASSERT_EQ(kill(getpid(), SIGHUP), 0);
    EXPECT_FALSE(signals.token().stop_requested());
    ASSERT_EQ(kill(getpid(), SIGTERM), 0);
    expect_stop(signals.token());
  }
  std::signal(SIGHUP, before);
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
