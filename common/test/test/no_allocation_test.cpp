#include "common/test/no_allocation.hpp"

#include <atomic>
#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>
#include <Eigen/Core>

namespace roadbalance::test {
namespace {

// The compiler may remove an allocation whose memory is never read; a volatile pointer shows it.
const void* volatile seen;
void see(const void* memory) {
  seen = memory;
}

TEST(NoAllocation, CountsNewInEveryForm) {
  NoAllocation guard;
  const auto one = std::make_unique<int>(1);
  see(one.get());
  EXPECT_EQ(guard.count(), 1U);
  const auto many = std::make_unique<int[]>(100);
  see(many.get());
  EXPECT_EQ(guard.count(), 2U);
  struct alignas(64) Wide {
    double value[8];
  };
  const auto aligned = std::make_unique<Wide>();
  see(aligned.get());
  EXPECT_EQ(guard.count(), 3U);
  guard.forgive();
}

TEST(NoAllocation, CountsMallocAndWhatEigenTakes) {
  NoAllocation guard;
  void* memory = std::malloc(100);
  see(memory);
  std::free(memory);
  EXPECT_EQ(guard.count(), 1U);
  const Eigen::VectorXd vector = Eigen::VectorXd::Ones(1'000);
  see(vector.data());
  EXPECT_EQ(guard.count(), 2U);
  guard.forgive();
}

TEST(NoAllocation, FailsTheTestThatAllocates) {
  EXPECT_NONFATAL_FAILURE(
      {
        const NoAllocation guard;
        see(std::make_unique<int>(1).get());
      },
      "allocations where none may happen");
}

TEST(NoAllocation, DoesNotBlameThisThreadForAnother) {
  std::atomic<bool> go = false;
  std::thread other([&] {
    while (!go) std::this_thread::yield();
    const std::vector<int> values(1'000);
    see(values.data());
    go = false;
  });
  {
    const NoAllocation guard;
    go = true;
    while (go) std::this_thread::yield();
  }
  other.join();
}

}  // namespace
}  // namespace roadbalance::test
