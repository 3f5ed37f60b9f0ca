#include "firmware/backends/usb/inbox.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace roadbalance {
namespace {

timespec in(int seconds) {
  timespec until{};
  ::clock_gettime(CLOCK_MONOTONIC, &until);
  until.tv_sec += seconds;
  return until;
}

// Hundreds of thousands of times the reader sees an item before, while and after it is called.
TEST(Inbox, EveryDeliveryArrivesOnceInOrderHoweverTheTwoThreadsMeet) {
  constexpr std::uint32_t kCount = 300'000;
  Inbox inbox;
  std::jthread writer([&] {
    for (std::uint32_t k = 0; k < kCount;) {
      BoardDelivery* const room = inbox.room();
      if (!room) {
        std::this_thread::yield();
        continue;
      }
      room->size = k++;
      inbox.post();
    }
  });
  for (std::uint32_t k = 0; k < kCount; ++k) {
    ASSERT_TRUE(inbox.front() || inbox.wait(in(60))) << k;
    ASSERT_EQ(inbox.front()->size, k);
    inbox.drop();
  }
  EXPECT_EQ(inbox.front(), nullptr);
  EXPECT_FALSE(inbox.wait(in(0)));
}

TEST(Inbox, HasNoRoomForMoreThanItHolds) {
  Inbox inbox;
  int held = 0;
  for (; inbox.room(); ++held) inbox.post();
  EXPECT_EQ(held, 256);
  inbox.drop();
  EXPECT_NE(inbox.room(), nullptr);
}

}  // namespace
}  // namespace roadbalance
