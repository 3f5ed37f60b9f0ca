#include "host/analysis/angle/recorded_speed.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace roadbalance {
namespace {

NodeTime at(double seconds) {
  return node_time_from_ns(std::llround(1e9 * seconds));
}

/// 20 m/s and 1 m/s^2 more each second, 50 messages a second.
std::vector<SignalSample> speeds(double from_s, double to_s) {
  std::vector<SignalSample> samples;
  for (int k = 0; from_s + 0.02 * k < to_s; ++k)
    samples.push_back({at(from_s + 0.02 * k), 0, 20.0 + from_s + 0.02 * k});
  return samples;
}

TEST(RecordedSpeed, IsTheIntegralOverTheRollingRadius) {
  const RecordedSpeed speed(speeds(0.0, 10.0), 0.3);
  std::array<double, 5> angle;
  ASSERT_TRUE(speed.turned(at(3.007), 1e7, angle));
  for (std::size_t i = 0; i < angle.size(); ++i) {
    const double t = 3.007 + 0.01 * static_cast<double>(i);
    EXPECT_NEAR(angle[i], (20.0 * t + 0.5 * t * t) / 0.3, 1e-6);
  }
}

TEST(RecordedSpeed, TellsNothingOutsideOfMessagesOrAcrossASilence) {
  auto samples = speeds(1.0, 4.0);
  const auto later = speeds(6.0, 8.0);
  samples.insert(samples.end(), later.begin(), later.end());
  const RecordedSpeed speed(samples, 0.3);
  EXPECT_EQ(speed.runs(), 2);
  std::array<double, 5> angle;
  EXPECT_FALSE(speed.turned(at(0.9), 1e6, angle));
  EXPECT_TRUE(speed.turned(at(2.0), 1e6, angle));
  EXPECT_FALSE(speed.turned(at(3.979), 1e6, angle));
  EXPECT_FALSE(speed.turned(at(5.0), 1e6, angle));
  EXPECT_TRUE(speed.turned(at(6.5), 1e6, angle));
  EXPECT_FALSE(speed.turned(at(7.999), 1e6, angle));
  EXPECT_FALSE(RecordedSpeed({}, 0.3).turned(at(0.0), 1e6, angle));
}

}  // namespace
}  // namespace roadbalance
