#include "host/analyser/tap_meter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace roadbalance {
namespace {

constexpr double kRate_hz = 2000.0;
constexpr double kScale = 1e-5;  // m/s^2 per count

/// Twelve channels with 0.02 m/s^2 of noise about gravity on the last, and whatever shakes them.
class TapMeterTest : public testing::Test {
 protected:
  TapMeterTest() : meter_(node()) {}

  static NodeConfig node() {
    NodeConfig node{.name = "front", .id = 3, .rate_hz = kRate_hz, .channel = {}};
    for (int c = 0; c < kAccelerations; ++c) {
      ChannelConfig& channel = node.channel.emplace_back();
      channel.name = std::to_string(c);
      channel.scale_m_s2_per_count = kScale;
    }
    return node;
  }

  /// @param shake  of channel and time, m/s^2
  void drive(
      double seconds, const std::function<double(int, double)>& shake = [](int, double) { return 0.0; }) {
    const auto blocks = static_cast<int>(seconds * kRate_hz / 20.0);
    for (int b = 0; b < blocks; ++b) {
      ScanBlock block;
      block.header = {
          .node = 3, .epoch = 1, .sequence = 1, .first_scan = scan_, .scans = 20, .time_ns = scan_ * 500'000};
      block.period_ps = 500'000'000;
      for (std::size_t r = 0; r < 20; ++r) {
        const double time_s = static_cast<double>(scan_ + static_cast<std::int64_t>(r)) / kRate_hz;
        for (int c = 0; c < kAccelerations; ++c) {
          const double value = 0.02 * noise_(random_) + (c == 11 ? 9.81 : 0.0) + shake(c, time_s);
          block.counts[r][static_cast<std::size_t>(c)] =
              static_cast<std::int32_t>(std::lround(value / kScale));
        }
        block.counts[r][12] = static_cast<std::int32_t>(kFullScaleCounts * std::sin(turning_rad_s_ * time_s));
        block.counts[r][13] = static_cast<std::int32_t>(kFullScaleCounts * std::cos(turning_rad_s_ * time_s));
        block.counts[r][15] = static_cast<std::int32_t>(kFullScaleCounts);
      }
      scan_ += 20;
      if (const auto tap = meter_.add(block)) heard_.push_back(*tap);
    }
  }
  double now_s() const { return static_cast<double>(scan_) / kRate_hz; }

  /// A damped ringing at 60 Hz whose first swing is the size given; half as late on a channel far away.
  static double ring(double size, double since_s) {
    if (since_s < 0.0) return 0.0;
    return size * std::exp(-since_s / 0.02) * std::sin(2.0 * std::numbers::pi * 60.0 * since_s);
  }

  TapMeter meter_;
  std::vector<Tap> heard_;
  std::int64_t scan_ = 0;
  double turning_rad_s_ = 0.0;
  std::mt19937_64 random_{7};
  std::normal_distribution<double> noise_;
};

TEST_F(TapMeterTest, TellsWhichChannelRangAndItsSign) {
  drive(2.0);
  const double at_s = now_s() + 0.1;
  drive(1.0, [&](int c, double time_s) {
    if (c == 4) return ring(-6.0, time_s - at_s);
    if (c == 11) return ring(2.0, time_s - at_s - 0.002);
    return 0.0;
  });
  ASSERT_EQ(heard_.size(), 1U);
  const Tap& tap = heard_[0];
  EXPECT_EQ(tap.node, 3);
  EXPECT_EQ(tap.number, 1);
  EXPECT_EQ(tap.channel, 4);
  EXPECT_NEAR(static_cast<double>(tap.time_ns) * 1e-9, at_s, 0.002);
  // The first peak of a sine that falls as exp(-t / 20 ms) is where tan(w t) = w 20 ms: 3.82 ms, 0.818 of it.
  const double peak = 6.0 * std::exp(-3.82e-3 / 0.02) * std::sin(2.0 * std::numbers::pi * 60.0 * 3.82e-3);
  EXPECT_NEAR(tap.first_m_s2[4], -peak, 0.1);
  EXPECT_NEAR(tap.peak_m_s2[4], peak, 0.1);
  EXPECT_NEAR(tap.first_m_s2[11], peak / 3.0, 0.1) << "gravity is no tap";
  EXPECT_LT(tap.peak_m_s2[0], 0.2);
}

TEST_F(TapMeterTest, CountsEachOnceAndTellsTheOtherSign) {
  drive(2.0);
  for (const double size : {3.0, -3.0, 3.0}) {
    const double at_s = now_s() + 0.05;
    drive(1.0, [&](int c, double time_s) { return c == 2 ? ring(size, time_s - at_s) : 0.0; });
    ASSERT_FALSE(heard_.empty());
    EXPECT_EQ(heard_.back().first_m_s2[2] > 0.0, size > 0.0);
  }
  ASSERT_EQ(heard_.size(), 3U);
  EXPECT_EQ(heard_[2].number, 3);
}

// Noise alone reaches 8 sigma once in 1e15 scans.
TEST_F(TapMeterTest, HearsNothingInQuiet) {
  drive(60.0);
  EXPECT_TRUE(heard_.empty());
}

TEST_F(TapMeterTest, HearsNothingWhileTheCarMoves) {
  turning_rad_s_ = 20.0;
  drive(2.0);
  const double at_s = now_s() + 0.1;
  drive(1.0, [&](int c, double time_s) { return c == 4 ? ring(6.0, time_s - at_s) : 0.0; });
  EXPECT_TRUE(heard_.empty()) << "its wheels turn";
  turning_rad_s_ = 0.0;
  const auto shaken = [](int, double time_s) { return std::sin(80.0 * time_s); };
  drive(2.0, shaken);
  const double again_s = now_s() + 0.1;
  drive(1.0, [&](int c, double time_s) {
    return shaken(c, time_s) + (c == 4 ? ring(20.0, time_s - again_s) : 0.0);
  });
  EXPECT_TRUE(heard_.empty()) << "it is shaken";
}

TEST_F(TapMeterTest, BeginsAnewBehindAHole) {
  drive(2.0);
  scan_ += 1000;
  drive(0.5, [](int, double) { return 5.0; });  // what was learned before does not count
  EXPECT_TRUE(heard_.empty());
}

}  // namespace
}  // namespace roadbalance
