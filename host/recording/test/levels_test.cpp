#include "host/recording/levels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace roadbalance {
namespace {

constexpr double kRate_hz = 2000.0;
constexpr double kRollingRadius_m = 0.31;
constexpr double kScale = 2e-5;  // m/s^2 per count

VehicleConfig vehicle() {
  VehicleConfig vehicle;
  vehicle.wheel[0].node = "front";
  vehicle.wheel[0].line = 0;
  vehicle.wheel[0].rolling_radius_m = kRollingRadius_m;
  NodeConfig node{"front", 1, kRate_hz, {}};
  for (int c = 0; c < 3; ++c) {
    ChannelConfig channel;
    channel.name = "c" + std::to_string(c);
    channel.scale_m_s2_per_count = c == 1 ? -kScale : kScale;
    channel.offset_counts = c == 0 ? 1000.0 : 0.0;
    node.channel.push_back(channel);
  }
  vehicle.node.push_back(node);
  return vehicle;
}

/// Blocks of a car at a constant wheel speed: channel 0 a sine about an offset, channel 1 a square wave,
/// channel 2 dead.
class Source {
 public:
  explicit Source(double wheel_hz) : wheel_hz_(wheel_hz) {}

  ScanBlock next() {
    ScanBlock block;
    block.header = {1, 1, ++sequence_, scan_, kScansPerBlock, scan_ * 500'000};
    block.period_ps = 500'000'000;
    for (auto& row : block.counts) {
      const double t = static_cast<double>(scan_++) / kRate_hz;
      const double angle = 2.0 * std::numbers::pi * wheel_hz_ * t;
      row[0] = static_cast<std::int32_t>(
          std::lround(1000.0 + 50'000.0 + 100'000.0 * std::sin(2.0 * std::numbers::pi * 10.0 * t)));
      row[1] = scan_ % 2 == 0 ? 7000 : -7000;
      row[2] = 42;
      row[12] = static_cast<std::int32_t>(std::lround(kFullScaleCounts * 0.9 * std::sin(angle)));
      row[13] = static_cast<std::int32_t>(std::lround(kFullScaleCounts * 0.9 * std::cos(angle)));
    }
    return block;
  }

 private:
  double wheel_hz_;
  std::int64_t scan_ = 0;
  std::int64_t sequence_ = 0;
};

TEST(LevelMeter, GivesMeanRmsAndPeakOfKnownSignals) {
  const VehicleConfig car = vehicle();
  LevelMeter meter(car, car.node[0]);
  Source source(15.0);
  for (int i = 0; i < 20; ++i) meter.add(source.next());  // 400 scans: two periods of the 10 Hz sine
  const auto level = meter.take();
  ASSERT_TRUE(level);
  EXPECT_NEAR(level->seconds, 0.2, 1e-12);
  EXPECT_EQ(level->time_ns, 200'000'000);
  // Rounding to whole counts disturbs by half a count at most.
  EXPECT_NEAR(level->mean[0], 50'000.0 * kScale, kScale);
  EXPECT_NEAR(level->rms[0], 100'000.0 / std::numbers::sqrt2 * kScale, kScale);
  EXPECT_NEAR(level->peak[0], 100'000.0 * kScale, 2.0 * kScale);
  EXPECT_NEAR(level->mean[1], 0.0, 1e-15);
  EXPECT_NEAR(level->rms[1], 7000.0 * kScale, 1e-12);
  EXPECT_NEAR(level->peak[1], 7000.0 * kScale, 1e-12);
  EXPECT_NEAR(level->rms[12], 0.9 / std::numbers::sqrt2, 1e-6);
}

TEST(LevelMeter, GivesTheSpeedFromTheReferenceWhateverItsAmplitude) {
  const VehicleConfig car = vehicle();
  for (const double wheel_hz : {0.5, 15.0, 30.0}) {
    LevelMeter meter(car, car.node[0]);
    Source source(wheel_hz);
    for (int i = 0; i < 10; ++i) meter.add(source.next());
    // Counts resolve the angle to 1e-7 rad, over 0.1 s.
    const auto level = meter.take();
    EXPECT_NEAR(level->speed_m_s, 2.0 * std::numbers::pi * wheel_hz * kRollingRadius_m, 1e-5);
    EXPECT_NEAR(level->rotation_hz[0], wheel_hz, 1e-5);
    EXPECT_TRUE(std::isnan(level->rotation_hz[1])) << "no wheel is on this line";
  }
}

TEST(LevelMeter, HasNoSpeedWithoutAReference) {
  const VehicleConfig car = vehicle();
  LevelMeter meter(car, car.node[0]);
  Source source(15.0);
  ScanBlock block = source.next();
  block.quality = kQualityNoReference0;
  meter.add(block);
  EXPECT_TRUE(std::isnan(meter.take()->speed_m_s));
}

TEST(LevelMeter, MarksTheDeadAndTheOverloadedChannel) {
  const VehicleConfig car = vehicle();
  LevelMeter meter(car, car.node[0]);
  Source source(15.0);
  for (int i = 0; i < 6; ++i) {
    ScanBlock block = source.next();
    block.overload = i == 3 ? 0b10 : 0;
    meter.add(block);
  }
  const auto level = meter.take();
  EXPECT_EQ(level->dead, 0b100U);  // not the channels that the node does not have
  EXPECT_EQ(level->overload, 0b10U);
  meter.add(source.next());
  EXPECT_EQ(meter.take()->overload, 0U);
  EXPECT_FALSE(meter.take());
}

}  // namespace
}  // namespace roadbalance
