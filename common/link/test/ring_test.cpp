#include "common/link/ring.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>

namespace roadbalance {
namespace {

constexpr std::size_t kSmallRing = 20 * sizeof(SealedBlock);

void put(Ring& ring) {
  SealedBlock* block = ring.claim();
  ASSERT_NE(block, nullptr);
  block->header.sequence = ring.next();
  block->size = static_cast<std::uint32_t>(ring.next() % 1000);
  ring.commit();
}

TEST(Ring, RefusesTheBlockThatDoesNotFitAndTakesItWhenOneIsFreed) {
  Ring ring(kSmallRing);
  ASSERT_EQ(ring.capacity(), 20);
  for (int k = 0; k < 20; ++k) put(ring);
  EXPECT_EQ(ring.claim(), nullptr);
  EXPECT_EQ(ring.used(), 20);
  ring.free_through(1);
  EXPECT_EQ(ring.used(), 19);
  put(ring);
  EXPECT_EQ(ring.claim(), nullptr);
}

TEST(Ring, KeepsEveryBlockUnalteredUntilItIsFreed) {
  Ring ring(kSmallRing);
  for (int turn = 0; turn < 100; ++turn) {
    while (ring.claim() != nullptr) put(ring);
    for (std::int64_t k = ring.base(); k < ring.next(); ++k) {
      ASSERT_EQ(ring.get(k).header.sequence, k);
      ASSERT_EQ(ring.get(k).size, k % 1000);
    }
    ring.free_through(ring.base() + turn % 20);
  }
}

TEST(Ring, FreesNothingTwice) {
  Ring ring(kSmallRing);
  for (int k = 0; k < 10; ++k) put(ring);
  ring.free_through(7);
  ring.free_through(3);
  EXPECT_EQ(ring.base(), 8);
  EXPECT_EQ(ring.used(), 3);
}

TEST(Ring, IsTooSmallBelowSixteenBlocks) {
  EXPECT_THROW(Ring(15 * sizeof(SealedBlock)), std::invalid_argument);
}

// The thread sanitizer proves that nothing is read while it is written.
TEST(Ring, PassesBlocksBetweenTwoThreadsInOrder) {
  Ring ring(kSmallRing);
  constexpr std::int64_t kBlocks = 20'000;
  std::jthread producer([&ring] {
    while (ring.next() <= kBlocks) {
      if (ring.claim() != nullptr)
        put(ring);
      else
        std::this_thread::yield();
    }
  });
  std::int64_t expected = 1;
  while (expected <= kBlocks) {
    if (expected == ring.next()) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(ring.get(expected).header.sequence, expected);
    ring.free_through(expected++);
  }
}

}  // namespace
}  // namespace roadbalance
