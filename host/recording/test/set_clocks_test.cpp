#include "host/recording/set_clocks.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace roadbalance {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000, kYears_us = 56LL * 365 * 86'400 * kSecond_us;

class SetClocksTest : public ::testing::Test {
 protected:
  void note(std::int64_t utc_us, std::int64_t host_s, NoteKind kind = NoteKind::kClock, std::int64_t a = 0,
            std::int64_t incarnation = 1) {
    clocks.take({.time_us = utc_us,
                 .host_ns = host_s * 1'000'000'000,
                 .incarnation = incarnation,
                 .kind = kind,
                 .a = a,
                 .text = {}});
  }
  SetClocks clocks;
};

TEST_F(SetClocksTest, MoveWhatWasStampedBefore) {
  note(10 * kSecond_us, 10);
  const auto before = clocks.stamp(15 * kSecond_us);
  EXPECT_EQ(clocks.utc_us(before), 15 * kSecond_us);
  note(kYears_us + 20 * kSecond_us, 20, NoteKind::kClockSet, kYears_us);
  const auto behind = clocks.stamp(kYears_us + 30 * kSecond_us);
  note(kYears_us + 39 * kSecond_us, 40, NoteKind::kClockSet, -kSecond_us);
  EXPECT_EQ(clocks.utc_us(before), kYears_us + 14 * kSecond_us);
  EXPECT_EQ(clocks.utc_us(behind), kYears_us + 29 * kSecond_us);
  EXPECT_EQ(clocks.utc_us({}), 0) << "it has no stamp";
}

// Power cut; the board comes back without a time and is given it.
TEST_F(SetClocksTest, LeaveWhatAComputerStampedBeforeItWasStartedAnew) {
  note(kYears_us, 1000);
  const auto right = clocks.stamp(kYears_us + kSecond_us);
  note(5 * kSecond_us, 5, NoteKind::kStarted, 1, 2);
  const auto wrong = clocks.stamp(6 * kSecond_us);
  note(kYears_us + 60 * kSecond_us, 10, NoteKind::kClockSet, kYears_us + 50 * kSecond_us, 2);
  EXPECT_EQ(clocks.utc_us(right), kYears_us + kSecond_us);
  EXPECT_EQ(clocks.utc_us(wrong), kYears_us + 56 * kSecond_us);
}

TEST_F(SetClocksTest, TakeNoChangeThatCannotBe) {
  note(kSecond_us, 1);
  const auto stamp = clocks.stamp(kSecond_us);
  for (const std::int64_t change :
       {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()})
    note(kSecond_us, 1, NoteKind::kClockSet, change);
  EXPECT_EQ(clocks.utc_us(stamp), kSecond_us);
  for (int k = 0; k < 20'000; ++k) note(kSecond_us, 1, NoteKind::kClockSet, kYears_us);
  EXPECT_LT(clocks.utc_us(stamp), 1'000 * kYears_us);
}

}  // namespace
}  // namespace roadbalance
