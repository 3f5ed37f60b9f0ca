#include "host/recorder/control/standstill_readings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace roadbalance {
namespace {

using std::chrono::milliseconds;

NodeConfig node() {
  NodeConfig node{.name = "front", .id = 1, .rate_hz = 2000, .channel = {}};
  for (int k = 0; k < 3; ++k)
    node.channel.push_back({.name = "c" + std::to_string(k), .mount = "body", .scale_m_s2_per_count = 1e-5});
  return node;
}

// 20 scans every 10 ms, for `blocks` of them.
template <typename Count>
StandstillReadings readings(int blocks, Count count) {
  StandstillReadings readings;
  for (int b = 0; b < blocks; ++b) {
    ScanBlock block{.header = {.node = 1, .scans = 20}};
    for (int scan = 0; scan < 20; ++scan)
      for (int k = 0; k < kChannels; ++k) block.counts[scan][k] = count(20 * b + scan, k);
    readings.take(block, WallTime{} + milliseconds(10 * b));
  }
  return readings;
}

TEST(StandstillReadings, AreTheMeansOfEachChannel) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1000);  // 0.01 m/s²
  const auto at_rest = readings(300, [&](int, int k) {
    return static_cast<std::int32_t>(std::lround(k < 3 ? 1e6 * (k + 1) + noise(random) : 0));
  });
  const auto reading = at_rest.of(node(), WallTime{} + milliseconds(3000));
  EXPECT_EQ(reading.fault, "");
  // Six standard deviations of the mean of 6000 scans.
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(reading.mean_counts[k], 1e6 * (k + 1), 6 * 1000 / std::sqrt(6000.0));
}

// By a set-up with another range the same acceleration has other counts.
TEST(StandstillReadings, BeginAgainWithEachEpoch) {
  StandstillReadings readings;
  for (int b = 0; b < 500; ++b) {
    ScanBlock block{.header = {.node = 1, .epoch = b < 250 ? 1 : 2, .scans = 20}};
    for (auto& row : block.counts) row[0] = b < 250 ? 1'000'000 : 500'000;
    readings.take(block, WallTime{} + milliseconds(10 * b));
    if (b == 349) {
      EXPECT_NE(readings.of(node(), WallTime{} + milliseconds(3490)).fault, "") << "one second of it";
    }
  }
  const auto reading = readings.of(node(), WallTime{} + milliseconds(4990));
  EXPECT_EQ(reading.fault, "");
  EXPECT_EQ(reading.mean_counts[0], 500'000);
}

TEST(StandstillReadings, ThereAreNoneWhileTheCarShakes) {
  // A sine of 2 m/s² has 1.41 rms.
  const auto shaking = readings(300, [](int scan, int k) {
    return static_cast<std::int32_t>(k == 1 ? 2e5 * std::sin(0.1 * scan) : 0);
  });
  EXPECT_EQ(shaking.of(node(), WallTime{} + milliseconds(3000)).fault,
            "channel c1 shakes by 1.4 m/s² rms: the car must stand still");
}

TEST(StandstillReadings, ThereAreNoneWhileAWheelTurns) {
  const auto turning = readings(300, [](int scan, int k) {
    return static_cast<std::int32_t>(k == kAccelerations ? 4e6 * std::sin(0.01 * scan) : 0);
  });
  EXPECT_EQ(turning.of(node(), WallTime{} + milliseconds(3000)).fault,
            "node front: a wheel turns: the car must stand still");
}

TEST(StandstillReadings, ThereAreNoneOfASilentNode) {
  const auto at_rest = readings(300, [](int, int) { return 5; });
  EXPECT_EQ(at_rest.of(node(), WallTime{} + milliseconds(3000)).fault, "");
  EXPECT_NE(at_rest.of(node(), WallTime{} + milliseconds(6100)).fault, "");
  EXPECT_NE(readings(100, [](int, int) { return 5; }).of(node(), WallTime{} + milliseconds(1000)).fault, "")
      << "one second is too short";
  EXPECT_NE(StandstillReadings().of(node(), WallTime{}).fault, "");
}

// The squares are kept about a first value: no offset, however large, may look like shaking.
TEST(StandstillReadings, AreNotMadeBlindByALargeOffset) {
  const auto at_rest = readings(300, [](int scan, int) { return 8'000'000 + (scan % 2); });
  EXPECT_EQ(at_rest.of(node(), WallTime{} + milliseconds(3000)).fault, "");
}

}  // namespace
}  // namespace roadbalance
