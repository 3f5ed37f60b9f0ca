#include "common/process/parallel.hpp"

#include <atomic>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "common/process/channel.hpp"

namespace roadbalance {
namespace {

void run_until_stopped(std::stop_token stop, std::atomic<int>& ended) {
  while (!stop.stop_requested()) std::this_thread::yield();
  ++ended;
}

TEST(Parallel, FirstToThrowStopsTheRestAndIsRethrown) {
  std::atomic<int> ended = 0;
  Parallel parallel;
  parallel.run(run_until_stopped, std::ref(ended));
  parallel.run(run_until_stopped, std::ref(ended));
  parallel.run([] { throw std::runtime_error("disk full"); });
  std::string reason;
  try {
    parallel.wait();
  } catch (const std::runtime_error& error) {
    reason = error.what();
  }
  EXPECT_EQ(reason, "disk full");
  EXPECT_EQ(ended, 2);
}

TEST(Parallel, RethrowsTheFirstOfSeveralFailures) {
  Parallel parallel;
  parallel.run([] { throw std::runtime_error("first"); });
  parallel.run([](const std::stop_token& stop) {
    while (!stop.stop_requested()) std::this_thread::yield();
    throw std::runtime_error("second");
  });
  try {
    parallel.wait();
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "first");
  }
}

TEST(Parallel, WaitsForProcessesThatEndByThemselves) {
  auto [out, in] = make_channel<int>(2);
  int sum = 0;
  Parallel parallel;
  parallel.run(
      [&sum](In<int> numbers) {
        while (const auto number = numbers.receive()) sum += *number;
      },
      std::move(in));
  parallel.run(
      [](Out<int> numbers) {
        for (int k = 1; k <= 100; ++k) ASSERT_TRUE(numbers.send(k));
      },
      std::move(out));
  parallel.wait();
  EXPECT_EQ(sum, 5'050);
  EXPECT_FALSE(parallel.stop_token().stop_requested());
}

TEST(Parallel, StopsOnRequestAndWhenItGoes) {
  std::atomic<int> ended = 0;
  {
    Parallel parallel;
    parallel.run(run_until_stopped, std::ref(ended));
    parallel.request_stop();
    parallel.wait();
    EXPECT_EQ(ended, 1);
  }
  {
    Parallel forgotten;
    forgotten.run(run_until_stopped, std::ref(ended));
  }
  EXPECT_EQ(ended, 2);
}

}  // namespace
}  // namespace roadbalance
