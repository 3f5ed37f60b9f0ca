#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "common/angle/wheel_encoder.hpp"
#include "sim/pulse_train.hpp"

// Counts that were lost, or were never fixed by a zero mark.

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr int kTeeth = 96;
constexpr double kPitch_rad = 2.0 * pi / kTeeth;

NodeTime at(double seconds) {
  return node_time_from_ns(std::llround(seconds * 1e9));
}
double seconds_of(const Edge& edge) {
  return static_cast<double>(to_ns(edge.time)) * 1e-9;
}
double drive(double t) {
  return 2.0 * pi * 18.0 * t + 0.5 * std::sin(1.3 * t);
}

class Resynchronise : public ::testing::Test {
 protected:
  void feed_until(double t) {
    for (; next < edges.size() && seconds_of(edges[next]) < t; ++next)
      encoder->add(edges[next].time, edges[next].kind);
  }
  /// Angle 80 ms before, less the truth, of [-pi, pi); nothing if it is not known.
  std::optional<double> error(double t, bool counted) {
    feed_until(t);
    std::array<double, 1> angle;
    const NodeTime when = at(t - 0.08);
    const bool known =
        counted ? encoder->counted_angles(when, 0.0, angle) : encoder->angles(when, 0.0, angle);
    if (!known) return std::nullopt;
    return std::remainder(angle[0] - train.angle_rad(t - 0.08), 2.0 * pi);
  }
  void make(bool zero_mark) {
    encoder.emplace(EncoderConfig{.pulses_per_turn = kTeeth, .zero_mark = zero_mark});
  }
  void no_marks_after(double t) {
    std::erase_if(edges, [&](const Edge& e) { return e.kind == EdgeKind::kZeroMark && seconds_of(e) > t; });
  }
  /// The line is dead meanwhile.
  void hole(double from, double to) {
    std::erase_if(edges, [&](const Edge& e) { return seconds_of(e) > from && seconds_of(e) < to; });
  }

  sim::PulseTrain train{
      .angle_rad = drive, .pitch_error_rad = sim::pitch_errors(kTeeth, 0.005, 3), .jitter_s = 5e-6};
  std::vector<Edge> edges = train.edges(0.0, 16.0);
  std::size_t next = 0;
  std::optional<WheelEncoder> encoder;
};

TEST_F(Resynchronise, TheRingItselfTellsTheToothAfterAHoleWhenMarksHaveStopped) {
  make(true);
  no_marks_after(7.9);
  hole(8.0, 8.3);
  ASSERT_TRUE(error(7.9, false));
  feed_until(8.35);
  EXPECT_FALSE(error(8.4, false));
  for (double t = 9.0; t < 15.9; t += 0.1) {
    const auto off = error(t, false);
    ASSERT_TRUE(off) << t;
    EXPECT_LT(std::abs(*off), 0.1 * kPitch_rad) << t;
    EXPECT_TRUE(encoder->uncertain()) << t;
  }
}

TEST_F(Resynchronise, AnEvenRingIsRefusedUntilAMarkComes) {
  train.pitch_error_rad = {};
  edges = train.edges(0.0, 16.0);
  make(true);
  std::erase_if(edges, [](const Edge& e) {
    return e.kind == EdgeKind::kZeroMark && seconds_of(e) > 7.9 && seconds_of(e) < 12.0;
  });
  hole(8.0, 8.3);
  for (double t = 8.4; t < 12.0; t += 0.1) EXPECT_FALSE(error(t, false)) << t;
  ASSERT_TRUE(error(12.3, false));
  EXPECT_LT(std::abs(*error(12.4, false)), 0.1 * kPitch_rad);
}

TEST_F(Resynchronise, ACountThatNoMarkHasConfirmedForLongIsUncertain) {
  make(true);
  no_marks_after(8.0);
  feed_until(8.3);
  EXPECT_FALSE(encoder->uncertain());
  feed_until(9.0);
  EXPECT_TRUE(encoder->uncertain());
  EXPECT_LT(std::abs(*error(9.0, false)), 0.1 * kPitch_rad);
}

TEST_F(Resynchronise, WithoutAMarkTheCountHoldsAndClaimsNoLocation) {
  make(false);
  train.jitter_s = 0.1 / (18.0 * kTeeth);  // a tenth of a pitch
  train.lost = train.extra = 0.01;
  edges = train.edges(0.0, 16.0);
  const auto start = error(2.0, true);
  ASSERT_TRUE(start);
  for (double t = 2.1; t < 15.9; t += 0.1) {
    EXPECT_FALSE(error(t, false));
    const auto off = error(t, true);
    ASSERT_TRUE(off) << t;
    EXPECT_LT(std::abs(std::remainder(*off - *start, 2.0 * pi)), 0.3 * kPitch_rad) << t;
  }
  EXPECT_EQ(encoder->count_restarts(), 1);
}

TEST_F(Resynchronise, WithoutAMarkTheRingGivesTheSameToothAfterAHole) {
  make(false);
  hole(8.0, 8.3);
  const auto before = error(7.9, true);
  ASSERT_TRUE(before);
  for (double t = 9.0; t < 15.9; t += 0.1) {
    const auto off = error(t, true);
    ASSERT_TRUE(off) << t;
    EXPECT_LT(std::abs(std::remainder(*off - *before, 2.0 * pi)), 0.1 * kPitch_rad) << t;
  }
  EXPECT_EQ(encoder->count_restarts(), 1);
}

TEST_F(Resynchronise, WithoutAMarkAnEvenRingCountsAnewAndSaysSo) {
  train.pitch_error_rad = {};
  edges = train.edges(0.0, 16.0);
  make(false);
  hole(8.0, 8.3);
  feed_until(7.9);
  EXPECT_EQ(encoder->count_restarts(), 1);
  feed_until(10.0);
  EXPECT_EQ(encoder->count_restarts(), 2);
  EXPECT_TRUE(error(10.0, true));
}

}  // namespace
}  // namespace roadbalance
