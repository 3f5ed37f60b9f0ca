#include "firmware/encoder/wheel_encoder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "firmware/test/pulse_train.hpp"

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
Errors follow(WheelEncoder& encoder, const test::PulseTrain& train, double seconds, double from_s,
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
  std::printf("rms %.4f max %.4f deg, unknown %d of %d, faulty %ld, table sigma %.4f deg\n", errors.rms_deg,
              errors.max_deg, errors.unknown, errors.blocks, long(encoder.faulty_turns()),
              encoder.pitch_table().sigma_pitches() * 360.0 / train.teeth);
  return errors;
}

TEST(WheelEncoder, MeetsTheAccuracyGoalAfterTwentySecondsOfLearning) {
  WheelEncoder encoder(ring(96));
  const test::PulseTrain train{
      .angle_rad = drive(), .pitch_error_rad = test::pitch_errors(96, 0.3 * kDegree, 5), .jitter_s = 5e-6};
  const Errors e = follow(encoder, train, 30.0, 20.0);
  EXPECT_EQ(e.unknown, 0);
  EXPECT_LE(e.rms_deg, 0.02);
  EXPECT_LE(e.max_deg, 0.1);
  EXPECT_EQ(encoder.faulty_turns(), 0);
}

TEST(WheelEncoder, FollowsTorsionalMotionAtWheelHop) {
  WheelEncoder encoder(ring(96));
  const test::PulseTrain train{.angle_rad = drive(1.0 * kDegree),
                               .pitch_error_rad = test::pitch_errors(96, 0.3 * kDegree, 6),
                               .jitter_s = 5e-6};
  const Errors e = follow(encoder, train, 30.0, 20.0);
  EXPECT_EQ(e.unknown, 0);
  EXPECT_LE(e.rms_deg, 0.05);
}

TEST(WheelEncoder, TakesAThousandPulseTransducer) {
  WheelEncoder encoder(ring(1000));
  const test::PulseTrain train{.angle_rad = drive(0.5 * kDegree), .teeth = 1000, .jitter_s = 2e-6};
  const Errors e = follow(encoder, train, 8.0, 3.0);
  EXPECT_EQ(e.unknown, 0);
  EXPECT_LE(e.rms_deg, 0.02);
}

TEST(WheelEncoder, SurvivesLostAndExtraPulses) {
  WheelEncoder encoder(ring(96));
  const test::PulseTrain train{.angle_rad = drive(),
                               .pitch_error_rad = test::pitch_errors(96, 0.3 * kDegree, 7),
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
  auto errors = test::pitch_errors(96, 0.3 * kDegree, 8);
  for (std::size_t k = 0; k < errors.size(); ++k)
    errors[k] += 0.5 * kDegree * std::sin(2.0 * pi * static_cast<double>(k) / 96.0 + 0.4);
  const test::PulseTrain train{.angle_rad = drive(), .pitch_error_rad = errors, .jitter_s = 5e-6};
  const Errors e = follow(encoder, train, 30.0, 20.0, config.datum_rad);
  EXPECT_LE(e.rms_deg, 0.02);
}

}  // namespace
}  // namespace roadbalance
