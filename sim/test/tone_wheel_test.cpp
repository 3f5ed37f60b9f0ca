#include "sim/tone_wheel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace roadbalance::sim {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kRadius_m = 0.3;
constexpr double kZeroAngle_rad = 1.234;
constexpr EncoderScenario kPitchErrors{0.08, 0.005, 0.25, 0.0};
const DriveScenario kWandering{{{25.0, 20.0}, {36.0, 20.0}}, 6.0, 0.14};

struct Case {
  EncoderScenario scenario = kPitchErrors;
  EncoderConfig encoder{.pulses_per_turn = 96, .datum_rad = 0.3};
  DriveScenario drive = kWandering;
  std::uint64_t seed = 4;
};

std::vector<Edge> edges_of(const Case& rig, double seconds) {
  const Drive drive(rig.drive, 9);
  const double rate_hz = 2000.0;
  ToneWheel wheel(rig.scenario, rig.seed, 1, rig.encoder, 1, kRadius_m, kZeroAngle_rad, {0.0, drive.at(0.0)});
  EdgeQueue queue(4096);
  std::vector<Edge> edges;
  ToneWheel::Instant last{0.0, drive.at(0.0)};
  for (int k = 1; k <= static_cast<int>(seconds * rate_hz); ++k) {
    const ToneWheel::Instant now{k / rate_hz, drive.at(k / rate_hz)};
    wheel.advance(last, now, queue);
    last = now;
    while (queue.due(node_time_from_ns(INT64_MAX))) edges.push_back(queue.take());
  }
  return edges;
}

double seconds(const Edge& edge) {
  return to_seconds(edge.time.time_since_epoch());
}

TEST(ToneWheel, EveryEdgeComesWhenItsAngleComes) {
  const Case rig;
  const Drive drive(rig.drive, 9);
  const ToneWheel wheel(rig.scenario, rig.seed, 1, rig.encoder, 1, kRadius_m, kZeroAngle_rad,
                        {0.0, drive.at(0.0)});
  const auto encoder_angle = [&](double t) {
    return drive.at(t).position_m / kRadius_m + kZeroAngle_rad - rig.encoder.datum_rad;
  };
  // Stamps are whole nanoseconds: 0.5 ns at 120 rad/s, and 1e-11 rad of rounding.
  const double tolerance_rad = 0.51e-9 * 125.0;
  std::int64_t tooth = 0, mark = static_cast<std::int64_t>(std::ceil(encoder_angle(0.0) / kTurn));
  while (wheel.tooth_angle_rad(tooth) <= encoder_angle(0.0)) ++tooth;
  while (wheel.tooth_angle_rad(tooth - 1) > encoder_angle(0.0)) --tooth;
  for (const Edge& edge : edges_of(rig, 30.0)) {
    ASSERT_EQ(edge.line, 1);
    const double angle_rad =
        edge.kind == EdgeKind::kTooth ? wheel.tooth_angle_rad(tooth++) : kTurn * static_cast<double>(mark++);
    ASSERT_NEAR(encoder_angle(seconds(edge)), angle_rad, tolerance_rad);
  }
}

TEST(ToneWheel, GivesAllTeethAndOneMarkEveryTurn) {
  for (const int pulses : {1, 48, 96, 1000}) {
    Case rig;
    rig.encoder.pulses_per_turn = pulses;
    int teeth = 0, marks = 0;
    for (const Edge& edge : edges_of(rig, 10.0)) {
      if (edge.kind == EdgeKind::kTooth) {
        ++teeth;
        continue;
      }
      if (marks++ > 0) {
        EXPECT_EQ(teeth, pulses);
      }
      teeth = 0;
    }
    EXPECT_GT(marks, 100);
  }
}

TEST(ToneWheel, HasNoZeroMarkWithoutOne) {
  Case rig;
  rig.encoder.zero_mark = false;
  for (const Edge& edge : edges_of(rig, 2.0)) EXPECT_EQ(edge.kind, EdgeKind::kTooth);
}

TEST(ToneWheel, PitchErrorsHaveZeroMeanTheGivenStrengthAndTheTeethStayInOrder) {
  const EncoderScenario scenario{0.08, 0.0, 0.25, 0.0};
  const Drive drive(kWandering, 9);
  const ToneWheel wheel(scenario, 4, 1, {.pulses_per_turn = 1000}, 0, kRadius_m, 0.0, {0.0, drive.at(0.0)});
  const double pitch_rad = kTurn / 1000;
  double sum = 0.0, square = 0.0;
  for (int n = 0; n < 1000; ++n) {
    const double error = wheel.tooth_angle_rad(n) / pitch_rad - n - 0.25;
    sum += error;
    square += error * error;
    EXPECT_GT(wheel.tooth_angle_rad(n + 1), wheel.tooth_angle_rad(n));
  }
  EXPECT_NEAR(sum, 0.0, 1e-9);
  // 1000 draws: the rms is good to 1 / sqrt(2000) = 2.2 %, a little less as the tails are short.
  EXPECT_NEAR(std::sqrt(square / 1000), 0.08, 4.5 * 0.022 * 0.08);
  EXPECT_NEAR(wheel.tooth_angle_rad(-1), wheel.tooth_angle_rad(999) - kTurn, 1e-12);
}

TEST(ToneWheel, StampsJitterByTheGivenAmountAndStayInOrderOfTime) {
  Case quiet, jittered;
  jittered.scenario.stamp_jitter_s = 20e-6;
  const auto a = edges_of(quiet, 20.0), b = edges_of(jittered, 20.0);
  ASSERT_EQ(a.size(), b.size());
  double square = 0.0;
  std::size_t teeth = 0;
  std::vector<double> ideal, found;
  for (const Edge& e : a)
    if (e.kind == EdgeKind::kTooth) ideal.push_back(seconds(e));
  for (const Edge& e : b)
    if (e.kind == EdgeKind::kTooth) found.push_back(seconds(e));
  // Teeth are at least 200 us apart and no jitter is beyond 70 us, so the order is kept.
  for (; teeth < ideal.size(); ++teeth) square += std::pow(found[teeth] - ideal[teeth], 2);
  EXPECT_NEAR(std::sqrt(square / static_cast<double>(teeth)), 20e-6,
              4.5 * 20e-6 / std::sqrt(2.0 * static_cast<double>(teeth)));
}

TEST(EdgeQueue, KeepsTheOrderOfStampsAndNeverGrows) {
  EdgeQueue queue(4);
  std::vector<std::int64_t> out;
  for (std::int64_t k = 0; k < 100; ++k) {
    queue.insert({node_time_from_ns(10 * k + 15), 0, EdgeKind::kTooth});
    queue.insert({node_time_from_ns(10 * k), 0, EdgeKind::kTooth});
    while (queue.due(node_time_from_ns(10 * k))) out.push_back(to_ns(queue.take().time));
  }
  EXPECT_EQ(out.size(), 198U);  // the last two of the late ones are not due yet
  EXPECT_TRUE(std::is_sorted(out.begin(), out.end()));
}

TEST(ToneWheel, IsSilentWhileTheCarStands) {
  Case rig;
  rig.drive = {{{0.0, 10.0}, {20.0, 10.0}, {0.0, 10.0}}, 4.0, 0.0};
  const Drive drive(rig.drive, 9);
  const auto edges = edges_of(rig, 30.0);
  ASSERT_FALSE(edges.empty());
  EXPECT_GT(seconds(edges.front()), 10.0);
  EXPECT_LT(seconds(edges.back()), 24.0);
  const double turns = drive.at(30.0).position_m / kRadius_m / kTurn;
  EXPECT_NEAR(static_cast<double>(edges.size()), turns * 97.0, 98.0);
  for (std::size_t i = 1; i < edges.size(); ++i) EXPECT_LE(edges[i - 1].time, edges[i].time);
}

}  // namespace
}  // namespace roadbalance::sim
