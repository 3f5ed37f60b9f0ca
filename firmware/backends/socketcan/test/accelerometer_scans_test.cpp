#include "firmware/backends/socketcan/accelerometer_scans.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace roadbalance {
namespace {

/// A module that converts every millisecond and its scans as the node has them.
struct Rig {
  /// The conversion `number` since the module was switched on at `on_ms`; its four parts or one frame.
  void convert(std::int64_t number, std::int64_t on_ms = 0, bool after_absence = false) {
    const std::int64_t at_ms = std::max(on_ms + number, not_before_ms);
    const NodeTime time = node_time_from_ns(at_ms * 1'000'000 + 5'000'000'000);
    for (int part = 0; part < (is_fd ? 1 : 4); ++part) {
      if (part == dropped_part) continue;
      AccelerometerFrame frame{.sequence = static_cast<std::uint32_t>(number), .part = part};
      if (is_fd) frame.part.reset();
      if (!is_fd) frame.sequence &= 0xFF;
      const int first = part * 3, count = is_fd ? 12 : 3;
      for (int k = first; k < first + count; ++k)
        frame.sample[static_cast<std::size_t>(k)] = static_cast<std::int16_t>(number + k);
      frame.overload = part == 3 ? 1 << 11 : 0;
      const auto scan =
          scans.add(frame, time + std::chrono::microseconds(150 * part), after_absence && part == 0);
      if (scan) got.push_back(*scan);
    }
  }
  bool is_fd = true;
  int dropped_part = -1;
  std::int64_t not_before_ms = 0;  ///< stamps
  AccelerometerScans scans;
  std::vector<Scan> got;
};

class AccelerometerScansTest : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override { rig.is_fd = GetParam(); }
  Rig rig;
};

TEST_P(AccelerometerScansTest, CountsScansThroughManyWrapsOfTheSequence) {
  for (std::int64_t number = 7; number < 2'007; ++number) rig.convert(number);
  ASSERT_EQ(rig.got.size(), 2'000U);
  for (std::size_t k = 0; k < rig.got.size(); ++k) {
    EXPECT_EQ(rig.got[k].index, static_cast<std::int64_t>(k));
    EXPECT_EQ(to_ns(rig.got[k].time), 5'007'000'000 + static_cast<std::int64_t>(k) * 1'000'000);
    for (std::size_t channel = 0; channel < 12; ++channel)
      ASSERT_EQ(rig.got[k].counts[channel], 256 * static_cast<int>(7 + k + channel));
    EXPECT_EQ(rig.got[k].overload, rig.is_fd ? 0U : 1U << 11);
  }
  EXPECT_EQ(rig.scans.missing(), 0);
}

TEST_P(AccelerometerScansTest, TurnsMissingNumbersIntoAJumpOfTheIndex) {
  for (const std::int64_t lost : {1, 17, 255, 256, 257, 1'000, 60'000}) {
    Rig one;
    one.is_fd = GetParam();
    one.convert(0);
    one.convert(1);
    const bool is_absent = lost > 500;
    one.convert(2 + lost, 0, is_absent);
    ASSERT_EQ(one.got.size(), 3U) << lost;
    EXPECT_EQ(one.got[2].index, 2 + lost);
    EXPECT_EQ(one.scans.missing(), is_absent ? 0 : lost);
    EXPECT_EQ(one.got[2].after_absence, is_absent);
    one.convert(3 + lost);
    EXPECT_FALSE(one.got[3].after_absence);
    EXPECT_EQ(one.got[3].index, 3 + lost);
  }
}

TEST_P(AccelerometerScansTest, FollowsTheStampsWhenTheModuleBeginsAnew) {
  for (const std::int64_t on_ms : {3'012, 3'100, 3'300, 4'900, 10'000})
    for (const std::int64_t first : {0, 3, 90, 200}) {  // conversion that is received first
      Rig one;
      one.is_fd = GetParam();
      for (std::int64_t number = 0; number < 3'000; ++number) one.convert(number);
      one.convert(first, on_ms);
      const Scan scan = one.got.back();
      // At 10 s the eight bits come within 16 of the stamps' numbers, by chance: this cannot be distinguished
      // from a module that went on, but for its 0.
      const bool is_like_going_on = !one.is_fd && on_ms == 10'000 && first > 0;
      EXPECT_NEAR(static_cast<double>(scan.index), static_cast<double>(on_ms + first),
                  is_like_going_on ? 16.0 : 0.0)
          << on_ms << ", " << first;
      EXPECT_EQ(scan.after_absence, !is_like_going_on) << on_ms << ", " << first;
      const std::int64_t missing = is_like_going_on ? scan.index - 3'000 : 0;
      EXPECT_EQ(one.scans.missing(), missing) << "they are those of a module that was not there";
      one.convert(first + 1, on_ms);
      EXPECT_EQ(one.got.back().index, scan.index + 1);
      EXPECT_FALSE(one.got.back().after_absence);
    }
}

TEST_P(AccelerometerScansTest, TakesNoBusyMachineForAModuleThatBeganAnew) {
  // For a time no frames are fetched; the controller keeps its first 16 conversions and loses the others.
  for (const std::int64_t busy_ms : {10, 60, 120}) {
    Rig one;
    one.is_fd = GetParam();
    for (std::int64_t number = 0; number < 600; ++number) {
      const bool is_held = number >= 200 && number < 200 + busy_ms;
      one.not_before_ms = is_held ? 200 + busy_ms : 0;
      if (!is_held || number < 216) one.convert(number);
    }
    const std::int64_t lost = std::max<std::int64_t>(0, busy_ms - 16);
    ASSERT_EQ(one.got.size(), static_cast<std::size_t>(600 - lost));
    EXPECT_EQ(one.scans.missing(), lost);
    for (std::size_t k = 0; k < one.got.size(); ++k) {
      const bool is_behind = k >= 200 + static_cast<std::size_t>(std::min<std::int64_t>(busy_ms, 16));
      ASSERT_EQ(one.got[k].index, static_cast<std::int64_t>(k) + (is_behind ? lost : 0));
      EXPECT_FALSE(one.got[k].after_absence);
    }
  }
}

TEST_P(AccelerometerScansTest, RefusesARepeatedConversion) {
  rig.convert(4);
  rig.convert(4);
  rig.convert(5);
  EXPECT_EQ(rig.got.size(), 2U);
  EXPECT_EQ(rig.scans.repeated(), 1);
  EXPECT_EQ(rig.got[1].index, 1);
}

INSTANTIATE_TEST_SUITE_P(Forms, AccelerometerScansTest, testing::Bool(),
                         [](const auto& form) { return form.param ? "CanFd" : "ClassicCan"; });

TEST(AccelerometerScans, LosesAConversionOfWhichAPartIsMissing) {
  for (int part = 0; part < 4; ++part) {
    Rig rig;
    rig.is_fd = false;
    rig.convert(0);
    rig.dropped_part = part;
    rig.convert(1);
    rig.dropped_part = -1;
    rig.convert(2);
    ASSERT_EQ(rig.got.size(), 2U) << part;
    EXPECT_EQ(rig.got[1].index, 2);
    EXPECT_EQ(rig.scans.missing(), 1);
  }
}

TEST(AccelerometerScans, DoesNotMixPartsOfTwoConversions) {
  AccelerometerScans scans;
  const auto add = [&](int part, std::uint32_t sequence) {
    return scans.add({.sequence = sequence, .part = part}, node_time_from_ns(sequence * 1'000'000), false);
  };
  EXPECT_FALSE(add(0, 1));
  EXPECT_FALSE(add(1, 1));
  EXPECT_FALSE(add(2, 2));  // parts 2, 3 of the first and 0, 1 of the second are lost
  EXPECT_FALSE(add(3, 2));
  EXPECT_FALSE(add(0, 3));
  EXPECT_FALSE(add(1, 3));
  EXPECT_FALSE(add(2, 3));
  EXPECT_TRUE(add(3, 3));
}

}  // namespace
}  // namespace roadbalance
