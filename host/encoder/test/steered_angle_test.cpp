#include "host/encoder/steered_angle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr double kDegree = pi / 180.0;
constexpr double kRatio = 1.0 / 16.0;

/// 30 degrees of the steering wheel either way, twice in four seconds.
double steering_rad(double t) {
  return 30.0 * kDegree * std::sin(2 * pi * 0.5 * t);
}
double wheel_rad(double t) {
  return 2 * pi * 15.0 * t + 0.5 * std::sin(0.7 * t);
}

std::vector<SignalSample> messages(double rate_hz, double from_s, double to_s) {
  std::vector<SignalSample> samples;
  for (int k = 0; from_s + k / rate_hz < to_s; ++k) {
    const double t = from_s + k / rate_hz;
    samples.push_back({node_time_from_ns(std::llround(1e9 * t)), 0, steering_rad(t)});
  }
  return samples;
}

struct Judged {
  double most_deg = 0.0;
  int uncertain = 0, blocks = 0;
};

Judged judge(SteeredAngle& angle, double from_s, double to_s) {
  Judged judged;
  std::array<double, 20> found;
  for (double start = from_s; start < to_s; start += 0.01) {
    const NodeTime first = node_time_from_ns(std::llround(1e9 * start));
    EXPECT_TRUE(angle.angles(first, 5e5, found)) << start;
    ++judged.blocks;
    judged.uncertain += angle.uncertain(first, first + NodeClock::duration(10'000'000)) ? 1 : 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double off = found[i] - wheel_rad(start + 5e-4 * static_cast<double>(i));
      judged.most_deg = std::max(judged.most_deg, std::abs(std::remainder(off, 2 * pi)) / kDegree);
    }
  }
  return judged;
}

class OnTheBody : public testing::Test {
 protected:
  const std::vector<Edge> edges_ =
      sim::PulseTrain{.angle_rad = [](double t) { return wheel_rad(t) + kRatio * steering_rad(t); },
                      .teeth = 1000,
                      .jitter_s = 1e-6}
          .edges(0.0, 12.0);
};

TEST_F(OnTheBody, LosesWhatSteeringAdds) {
  SteeredAngle plain({.pulses_per_turn = 1000}, edges_, {});
  EXPECT_NEAR(judge(plain, 1.0, 11.0).most_deg, 30.0 / 16.0, 0.05) << "what there is to take off";
  for (const double rate_hz : {100.0, 50.0, 20.0}) {
    SteeredAngle angle({.pulses_per_turn = 1000, .steering_ratio = kRatio}, edges_,
                       messages(rate_hz, 0.0, 12.0));
    const Judged judged = judge(angle, 1.0, 11.0);
    std::printf("%3.0f Hz: %.4f degrees at the most\n", rate_hz, judged.most_deg);
    // A straight line is off by a'' / (8 f^2), at 20 Hz 0.006 degrees after the ratio.
    EXPECT_LT(judged.most_deg, 0.02) << rate_hz;
    EXPECT_EQ(judged.uncertain, 0) << rate_hz;
  }
}

TEST_F(OnTheBody, IsUncertainWhereNoMessageTells) {
  const EncoderConfig config{.pulses_per_turn = 1000, .steering_ratio = kRatio};
  SteeredAngle without(config, edges_, {});
  const Judged deaf = judge(without, 1.0, 2.0);
  EXPECT_EQ(deaf.uncertain, deaf.blocks);
  auto samples = messages(50.0, 0.0, 4.0);
  const auto later = messages(50.0, 8.0, 12.0);
  samples.insert(samples.end(), later.begin(), later.end());
  SteeredAngle hole(config, edges_, samples);
  EXPECT_EQ(judge(hole, 1.0, 4.9).uncertain, 0) << "held for a second";
  const Judged silent = judge(hole, 5.02, 7.9);
  EXPECT_EQ(silent.uncertain, silent.blocks);
  EXPECT_EQ(judge(hole, 8.01, 11.0).uncertain, 0);
}

}  // namespace
}  // namespace roadbalance
