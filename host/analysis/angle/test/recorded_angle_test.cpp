#include "host/analysis/angle/recorded_angle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr double kDegree = pi / 180.0;

NodeTime at(double seconds) {
  return node_time_from_ns(std::llround(seconds * 1e9));
}

struct Judged {
  double rms_deg = 0.0;
  int known = 0, blocks = 0;
};

/// Blocks of 10 ms in [from, to) against the truth.
Judged judge(RecordedAngle& recorded, const sim::PulseTrain& train, double from_s, double to_s,
             double datum_rad = 0.0) {
  Judged judged;
  double square = 0.0;
  std::array<double, 20> angle;
  for (double start = from_s; start < to_s - 0.01; start += 0.01) {
    ++judged.blocks;
    if (!recorded.angles(at(start), 5e5, angle)) continue;
    ++judged.known;
    for (std::size_t i = 0; i < angle.size(); ++i) {
      const double truth = train.angle_rad(start + 5e-4 * static_cast<double>(i)) + datum_rad;
      square += std::pow(std::remainder(angle[i] - truth, 2.0 * pi) / kDegree, 2) / 20.0;
    }
  }
  judged.rms_deg = std::sqrt(square / std::max(1, judged.known));
  return judged;
}

const auto kDrive = [](double t) { return 2.0 * pi * 15.0 * t + 0.8 * std::sin(1.3 * t) + 1.0; };

TEST(RecordedAngle, IsAsGoodAtTheBeginAsAtTheEnd) {
  const sim::PulseTrain train{
      .angle_rad = kDrive, .pitch_error_rad = sim::pitch_errors(96, 0.3 * kDegree, 5), .jitter_s = 10e-6};
  RecordedAngle recorded({.pulses_per_turn = 96, .datum_rad = 0.7}, train.edges(0.0, 20.0));
  const Judged begin = judge(recorded, train, 0.1, 3.0, 0.7), end = judge(recorded, train, 16.0, 19.9, 0.7);
  EXPECT_EQ(begin.known, begin.blocks);
  EXPECT_EQ(end.known, end.blocks);
  EXPECT_LT(begin.rms_deg, 0.015);
  EXPECT_LT(end.rms_deg, 0.015);
  // Its stated uncertainty is right, up to what is no noise: half to twice.
  EXPECT_GT(recorded.sigma_rad() / kDegree, 0.5 * end.rms_deg);
  EXPECT_LT(recorded.sigma_rad() / kDegree, 2.0 * end.rms_deg);
  // And may be asked in any order.
  EXPECT_LT(judge(recorded, train, 0.1, 1.0, 0.7).rms_deg, 0.015);
}

TEST(RecordedAngle, FlagsTurnsWithoutExactlyTheirTeeth) {
  const sim::PulseTrain train{.angle_rad = kDrive};
  auto edges = train.edges(0.0, 6.0);
  const auto gone = std::ranges::find_if(
      edges, [](const Edge& e) { return e.time > at(3.0) && e.kind == EdgeKind::kTooth; });
  const NodeTime fault = gone->time;
  edges.erase(gone);
  RecordedAngle recorded({.pulses_per_turn = 96}, edges);
  const auto turn = NodeClock::duration(70'000'000);
  EXPECT_TRUE(recorded.uncertain(fault, fault));
  EXPECT_FALSE(recorded.uncertain(fault - 3 * turn, fault - turn));
  EXPECT_FALSE(recorded.uncertain(fault + turn, fault + 3 * turn));
  EXPECT_LT(judge(recorded, train, 0.1, 5.9).rms_deg, 0.002);
}

TEST(RecordedAngle, HasNoneWhereTheWheelStoodOrNoMarkCame) {
  const sim::PulseTrain train{
      .angle_rad = [](double t) { return t < 3.0 ? 90.0 * t : std::max(270.0, 90.0 * (t - 2.0)); }};
  RecordedAngle recorded({.pulses_per_turn = 96}, train.edges(0.0, 8.0));
  EXPECT_EQ(judge(recorded, train, 3.1, 4.9).known, 0);
  const Judged after = judge(recorded, train, 5.1, 7.9);
  EXPECT_EQ(after.known, after.blocks);
  EXPECT_LT(after.rms_deg, 0.002);
  std::array<double, 2> angle;
  EXPECT_FALSE(recorded.angles(at(-1.0), 1e6, angle));
  EXPECT_FALSE(recorded.angles(at(9.0), 1e6, angle));

  RecordedAngle markless({.pulses_per_turn = 96, .zero_mark = false}, train.edges(0.0, 2.0));
  EXPECT_FALSE(markless.angles(at(1.0), 1e6, angle));
  RecordedAngle empty({.pulses_per_turn = 96}, {});
  EXPECT_FALSE(empty.angles(at(1.0), 1e6, angle));
}

// From pulses of a wheel with a few strangers to nothing but strangers.
TEST(RecordedAngle, IsNotUpsetByPulsesThatMakeNoSense) {
  std::mt19937_64 random(3);
  int known = 0;
  for (const std::uint64_t strangers : {20U, 200U, 2000U, 1'000'000U}) {
    std::vector<Edge> edges = sim::PulseTrain{.angle_rad = kDrive, .jitter_s = 50e-6}.edges(0.0, 10.0);
    for (Edge& edge : edges) {
      const auto dice = random() % 1'000'000;
      if (dice >= strangers) continue;
      edge.time += NodeClock::duration(static_cast<std::int64_t>(random() % 4'000'000) >> (random() % 20));
      edge.kind = dice % 50 == 0   ? EdgeKind::kToothBackward
                  : dice % 50 == 1 ? EdgeKind::kLost
                  : dice % 50 < 4  ? EdgeKind::kZeroMark
                                   : EdgeKind::kTooth;
    }
    std::ranges::stable_sort(edges, {}, &Edge::time);
    RecordedAngle recorded({.pulses_per_turn = 96}, edges);
    std::array<double, 20> angle;
    for (double start = 0.0; start < 10.0; start += 0.005) {
      if (!recorded.angles(at(start), 5e5, angle)) continue;
      ++known;
      for (const double a : angle) ASSERT_TRUE(std::isfinite(a)) << strangers << " at " << start;
    }
  }
  EXPECT_GT(known, 2000);
}

TEST(RecordedAngle, OfARingWithoutMarkTellsHowFarTheWheelHasTurned) {
  const sim::PulseTrain train{.angle_rad = [](double t) { return 2 * pi * (12.0 * t + 0.2 * t * t); },
                              .jitter_s = 2e-6};
  auto edges = train.edges(0.0, 10.0);
  std::erase_if(edges, [](const Edge& edge) { return edge.kind == EdgeKind::kZeroMark; });
  RecordedAngle recorded({.pulses_per_turn = 96, .zero_mark = false}, edges);
  std::array<double, 2> from, to;
  EXPECT_FALSE(recorded.angles(at(2.0), 5e5, from));
  ASSERT_TRUE(recorded.turned(at(2.0), 5e5, from));
  ASSERT_TRUE(recorded.turned(at(8.0), 5e5, to));
  EXPECT_NEAR((to[0] - from[0] - train.angle_rad(8.0) + train.angle_rad(2.0)) / kDegree, 0.0, 0.05);
  // With its marks that is not needed.
  RecordedAngle marked({.pulses_per_turn = 96}, train.edges(0.0, 10.0));
  EXPECT_FALSE(marked.turned(at(2.0), 5e5, from));
  EXPECT_TRUE(marked.angles(at(2.0), 5e5, from));
}

}  // namespace
}  // namespace roadbalance
