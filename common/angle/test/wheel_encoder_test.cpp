#include "common/angle/wheel_encoder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr double kDegree = pi / 180.0;
constexpr double kBlock_s = 0.01, kHalfStep_s = 0.00025;

EncoderConfig ring(int teeth) {
  return {.pulses_per_turn = teeth, .zero_mark = true, .datum_rad = 0.0};
}

/// 18 turns a second with a slow wander and, if asked, torsional motion.
std::function<double(double)> drive(double torsion_rad = 0.0, double torsion_hz = 13.0) {
  return [=](double t) {
    return 2.0 * pi * 18.0 * t + 0.8 * std::sin(2.0 * pi * 0.21 * t) +
           torsion_rad * std::sin(2.0 * pi * torsion_hz * t) + 1.0;
  };
}

struct Errors {
  double rms_deg = 0.0, max_deg = 0.0;
  int blocks = 0, unknown = 0;
};

/// Runs the encoder as a node does, block by block with the shortest lag, and compares with the truth.
Errors follow(WheelEncoder& encoder, const sim::PulseTrain& train, double seconds, double from_s,
              double datum_rad = 0.0) {
  const auto edges = train.edges(0.0, seconds);
  Errors errors;
  double square = 0.0;
  std::int64_t count = 0;
  std::size_t next = 0;
  std::array<double, 40> angle;
  for (double start = 0.0; start + 0.1 < seconds; start += kBlock_s) {
    const NodeTime first = node_time_from_ns(std::llround(start * 1e9));
    const NodeTime last = node_time_from_ns(std::llround((start + 39 * kHalfStep_s) * 1e9));
    while (next < edges.size() && edges[next].time < encoder.complete_at(last)) {
      encoder.add(edges[next].time, edges[next].kind);
      ++next;
    }
    if (start < from_s) continue;
    ++errors.blocks;
    if (!encoder.angles(first, kHalfStep_s * 1e9, angle)) {
      ++errors.unknown;
      continue;
    }
    for (std::size_t i = 0; i < angle.size(); ++i) {
      const double truth = train.angle_rad(start + static_cast<double>(i) * kHalfStep_s) + datum_rad;
      const double error = std::remainder(angle[i] - truth, 2.0 * pi) / kDegree;
      square += error * error;
      errors.max_deg = std::max(errors.max_deg, std::abs(error));
      ++count;
    }
  }
  errors.rms_deg = std::sqrt(square / static_cast<double>(count));
  return errors;
}

TEST(WheelEncoder, MeetsTheAccuracyGoalAfterTwentySecondsOfLearning) {
  WheelEncoder encoder(ring(96));
  const sim::PulseTrain train{
      .angle_rad = drive(), .pitch_error_rad = sim::pitch_errors(96, 0.3 * kDegree, 5), .jitter_s = 5e-6};
  const Errors e = follow(encoder, train, 30.0, 20.0);
  EXPECT_EQ(e.unknown, 0);
  EXPECT_LE(e.rms_deg, 0.02);
  EXPECT_LE(e.max_deg, 0.1);
  EXPECT_EQ(encoder.faulty_turns(), 0);
}

TEST(WheelEncoder, FollowsTorsionalMotionAtWheelHop) {
  WheelEncoder encoder(ring(96));
  const sim::PulseTrain train{.angle_rad = drive(1.0 * kDegree),
                              .pitch_error_rad = sim::pitch_errors(96, 0.3 * kDegree, 6),
                              .jitter_s = 5e-6};
  const Errors e = follow(encoder, train, 30.0, 20.0);
  EXPECT_EQ(e.unknown, 0);
  EXPECT_LE(e.rms_deg, 0.05);
}

TEST(WheelEncoder, TakesAThousandPulseTransducer) {
  WheelEncoder encoder(ring(1000));
  const sim::PulseTrain train{.angle_rad = drive(0.5 * kDegree), .teeth = 1000, .jitter_s = 2e-6};
  const Errors e = follow(encoder, train, 8.0, 3.0);
  EXPECT_EQ(e.unknown, 0);
  EXPECT_LE(e.rms_deg, 0.02);
}

TEST(WheelEncoder, TakesThePulseOfATachometerForItsZeroMark) {
  WheelEncoder encoder(ring(1));
  // Zero marks come with it, a radian before: they count nothing.
  const sim::PulseTrain train{
      .angle_rad = [](double t) { return 2.0 * pi * 45.0 * t + 0.8 * std::sin(2.0 * pi * 0.21 * t) + 1.0; },
      .teeth = 1,
      .first_tooth_rad = 1.0,
      .jitter_s = 10e-6};
  const Errors e = follow(encoder, train, 8.0, 1.0, -1.0);
  EXPECT_EQ(e.unknown, 0);
  EXPECT_LE(e.rms_deg, 360.0 * 45.0 * 10e-6) << "between pulses as well as at one";
  EXPECT_EQ(encoder.faulty_turns(), 0);
}

TEST(WheelEncoder, SurvivesLostAndExtraPulses) {
  WheelEncoder encoder(ring(96));
  const sim::PulseTrain train{.angle_rad = drive(),
                              .pitch_error_rad = sim::pitch_errors(96, 0.3 * kDegree, 7),
                              .jitter_s = 10e-6,
                              .lost = 0.01,
                              .extra = 0.01};
  const Errors e = follow(encoder, train, 30.0, 20.0);
  EXPECT_EQ(e.unknown, 0);
  EXPECT_LE(e.rms_deg, 0.03);
  EXPECT_LE(e.max_deg, 0.5);
  EXPECT_GT(encoder.faulty_turns(), 100);  // nearly every turn has a fault at these shares
}

TEST(WheelEncoder, LearnsEccentricityAndAddsTheDatum) {
  auto config = ring(96);
  config.datum_rad = 0.7;
  WheelEncoder encoder(config);
  auto errors = sim::pitch_errors(96, 0.3 * kDegree, 8);
  for (std::size_t k = 0; k < errors.size(); ++k)
    errors[k] += 0.5 * kDegree * std::sin(2.0 * pi * static_cast<double>(k) / 96.0 + 0.4);
  const sim::PulseTrain train{.angle_rad = drive(), .pitch_error_rad = errors, .jitter_s = 5e-6};
  const Errors e = follow(encoder, train, 30.0, 20.0, config.datum_rad);
  EXPECT_LE(e.rms_deg, 0.02);
}

/// Feeds edges and reports for each block of 10 ms whether the angle was known; checks it against the truth.
class Drive {
 public:
  explicit Drive(WheelEncoder& encoder) : encoder_(encoder) {}

  /// Share of blocks with a known angle in [from, to); `truth` of seconds.
  double known(const std::vector<Edge>& edges, double from_s, double to_s,
               const std::function<double(double)>& truth, double tolerance_rad) {
    int known = 0, blocks = 0;
    double worst_rad = 0.0;
    std::array<double, 20> angle;
    for (double start = from_s; start < to_s; start += kBlock_s, ++blocks) {
      const NodeTime last = node_time_from_ns(std::llround((start + kBlock_s) * 1e9));
      for (; next_ < edges.size() && edges[next_].time < encoder_.complete_at(last); ++next_)
        encoder_.add(edges[next_].time, edges[next_].kind);
      if (!encoder_.angles(node_time_from_ns(std::llround(start * 1e9)), 0.5e6, angle)) continue;
      ++known;
      for (std::size_t i = 0; i < angle.size(); ++i)
        worst_rad = std::max(
            worst_rad,
            std::abs(std::remainder(angle[i] - truth(start + 0.0005 * static_cast<double>(i)), 2.0 * pi)));
    }
    EXPECT_LE(worst_rad, tolerance_rad);
    return static_cast<double>(known) / blocks;
  }

 private:
  WheelEncoder& encoder_;
  std::size_t next_ = 0;
};

std::vector<Edge> without(std::vector<Edge> edges, const std::function<bool(const Edge&)>& drop) {
  std::erase_if(edges, drop);
  return edges;
}
double seconds_of(const Edge& edge) {
  return static_cast<double>(to_ns(edge.time)) * 1e-9;
}

TEST(WheelEncoder, KnowsNoAngleBeforeTheFirstZeroMarkAndAlwaysAfter) {
  WheelEncoder encoder(ring(96));
  const sim::PulseTrain train{.angle_rad = drive()};
  auto edges = without(train.edges(0.0, 3.0),
                       [](const Edge& e) { return e.kind == EdgeKind::kZeroMark && seconds_of(e) < 1.0; });
  Drive test(encoder);
  EXPECT_EQ(test.known(edges, 0.0, 0.98, train.angle_rad, 0.001), 0.0);
  EXPECT_EQ(test.known(edges, 1.1, 2.9, train.angle_rad, 0.001), 1.0);
}

TEST(WheelEncoder, ClaimsNoAngleWithoutAZeroMark) {
  auto config = ring(96);
  config.zero_mark = false;
  WheelEncoder encoder(config);
  const sim::PulseTrain train{.angle_rad = drive()};
  Drive test(encoder);
  EXPECT_EQ(test.known(train.edges(0.0, 2.0), 0.0, 1.9, train.angle_rad, 0.0), 0.0);
  EXPECT_NEAR(encoder.speed_rad_s(node_time_from_ns(1'900'000'000)), 2.0 * pi * 18.0, 2.0);
}

TEST(WheelEncoder, BridgesMissingZeroMarksAndDropsFalseOnes) {
  WheelEncoder encoder(ring(96));
  const sim::PulseTrain train{.angle_rad = drive()};
  int mark = 0;
  auto edges = without(train.edges(0.0, 6.0),
                       [&](const Edge& e) { return e.kind == EdgeKind::kZeroMark && (++mark % 3) == 0; });
  for (const double t : {2.013, 3.021, 3.5055, 4.7})
    edges.push_back({node_time_from_ns(std::llround(t * 1e9)), 0, EdgeKind::kZeroMark});
  std::stable_sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.time < b.time; });
  Drive test(encoder);
  EXPECT_EQ(test.known(edges, 0.3, 5.8, train.angle_rad, 0.001), 1.0);
  EXPECT_EQ(encoder.faulty_turns(), 4);
}

TEST(WheelEncoder, FindsTheToothAgainAfterAHoleInThePulses) {
  WheelEncoder encoder(ring(96));
  const sim::PulseTrain train{.angle_rad = drive()};
  const auto edges = without(train.edges(0.0, 4.0), [](const Edge& e) {
    return (seconds_of(e) > 1.5 && seconds_of(e) < 1.58) || (seconds_of(e) > 2.5 && seconds_of(e) < 2.503);
  });
  Drive test(encoder);
  EXPECT_EQ(test.known(edges, 0.3, 1.47, train.angle_rad, 0.001), 1.0);
  test.known(edges, 1.47, 1.7, train.angle_rad, 0.001);  // it may be unknown for a turn, but is never wrong
  EXPECT_EQ(test.known(edges, 1.7, 3.9, train.angle_rad, 0.001), 1.0);  // over the short hole, too
  EXPECT_GE(encoder.faulty_turns(), 2);
}

TEST(WheelEncoder, StandsStillAndStartsAgain) {
  WheelEncoder encoder(ring(96));
  const sim::PulseTrain train{.angle_rad = drive()};
  const auto edges = without(train.edges(0.0, 6.0),
                             [](const Edge& e) { return seconds_of(e) > 2.0 && seconds_of(e) < 4.0; });
  Drive test(encoder);
  EXPECT_EQ(test.known(edges, 0.3, 1.98, train.angle_rad, 0.001), 1.0);
  EXPECT_EQ(test.known(edges, 2.01, 3.98, train.angle_rad, 0.001), 0.0);
  EXPECT_EQ(encoder.speed_rad_s(node_time_from_ns(3'900'000'000)), 0.0);
  EXPECT_EQ(test.known(edges, 4.1, 5.9, train.angle_rad, 0.001), 1.0);
}

TEST(WheelEncoder, FlagsTheTurnInWhichAToothIsMissing) {
  WheelEncoder encoder(ring(96));
  const sim::PulseTrain train{.angle_rad = drive()};
  bool dropped = false, flagged = false;
  for (const Edge& edge : train.edges(0.0, 3.0)) {
    if (!dropped && edge.kind == EdgeKind::kTooth && seconds_of(edge) > 1.5) {
      dropped = true;
      continue;
    }
    encoder.add(edge.time, edge.kind);
    if (seconds_of(edge) < 1.5) {
      EXPECT_FALSE(encoder.uncertain());
    }
    if (encoder.uncertain()) flagged = true;
    if (seconds_of(edge) > 1.65) {  // two turns later
      EXPECT_FALSE(encoder.uncertain());
    }
  }
  EXPECT_TRUE(flagged);
  EXPECT_EQ(encoder.faulty_turns(), 1);
}

TEST(WheelEncoder, FollowsFromWalkingPaceToFullSpeedAndBack) {
  WheelEncoder encoder(ring(96));
  // 0.4 to 20 turns a second and back within 20 s: braking of 4 m/s^2 at a radius of 0.3 m.
  const sim::PulseTrain train{.angle_rad = [](double t) {
    return 2.0 * pi * (10.2 * t - 9.8 * 20.0 / (2.0 * pi) * std::sin(2.0 * pi * t / 20.0));
  }};
  Drive test(encoder);
  EXPECT_EQ(test.known(train.edges(0.0, 20.0), 3.0, 17.0, train.angle_rad, 0.003), 1.0);
}

TEST(WheelEncoder, IsNotUpsetByPulsesThatMakeNoSense) {
  WheelEncoder encoder(ring(96));
  std::mt19937_64 random(3);
  std::uniform_int_distribution<std::int64_t> step(0, 2'000'000);
  std::array<double, 40> angle;
  std::int64_t t = 0;
  for (int i = 0; i < 50'000; ++i) {
    t += step(random) >> (random() % 20);
    encoder.add(node_time_from_ns(t), random() % 50 == 0 ? EdgeKind::kZeroMark : EdgeKind::kTooth);
    if (i % 100 == 0 && encoder.angles(node_time_from_ns(t - 20'000'000), 250'000.0, angle)) {
      for (const double a : angle) ASSERT_TRUE(std::isfinite(a));
    }
  }
  // And a wheel that turns afterwards is followed as ever.
  const double start = static_cast<double>(t) * 1e-9 + 0.5;
  const sim::PulseTrain train{.angle_rad = drive()};
  Drive test(encoder);
  const auto edges = train.edges(start, start + 8.0);
  // A table learned from noise gives way within a few seconds.
  test.known(edges, start, start + 6.0, train.angle_rad, pi);
  EXPECT_EQ(test.known(edges, start + 6.0, start + 7.9, train.angle_rad, 2.0 * pi / 96 / 2), 1.0);
}

}  // namespace
}  // namespace roadbalance
