#include "firmware/backends/socketcan/accelerometer_scans.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace roadbalance {
namespace {

/// A module that converts every millisecond and its scans as the node has them.
struct Rig {
  /// The conversion `number` since the module was switched on at `on_ms`; its four parts or one frame.
  void convert(std::int64_t number, std::int64_t on_ms = 0, bool after_absence = false) {
    const NodeTime time = node_time_from_ns((on_ms + number) * 1'000'000 + 5'000'000'000);
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
    one.convert(2 + lost, 0, lost > 500);
    ASSERT_EQ(one.got.size(), 3U) << lost;
    EXPECT_EQ(one.got[2].index, 2 + lost);
    EXPECT_EQ(one.scans.missing(), lost);
    EXPECT_EQ(one.got[2].after_absence, lost > 500);
    one.convert(3 + lost);
    EXPECT_FALSE(one.got[3].after_absence);
    EXPECT_EQ(one.got[3].index, 3 + lost);
  }
}

TEST_P(AccelerometerScansTest, FollowsTheStampsWhenTheModuleBeginsAnew) {
  for (std::int64_t number = 0; number < 3'000; ++number) rig.convert(number);
  rig.convert(0, 10'000);  // switched on 7 s after its last conversion at 2999
  // Of eight bits the number is taken as it is, so that the index is right but for half a turn.
  EXPECT_NEAR(static_cast<double>(rig.got.back().index), 10'000, rig.is_fd ? 0 : 128);
  const std::int64_t index = rig.got.back().index;
  rig.convert(1, 10'000);
  EXPECT_EQ(rig.got.back().index, index + 1);
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
