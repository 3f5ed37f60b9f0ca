#include "host/analysis/calibration/datum_readings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kCycle_s = 8.0;  ///< five of turning, three of standing
constexpr int kTeeth = 96;

/// A hand turns the wheel on by somewhat more than a turn, each time by another way.
double by_hand_rad(double time_s) {
  const double cycle = std::floor(time_s / kCycle_s);
  const double part = std::clamp((time_s - cycle * kCycle_s) / 5.0, 0.0, 1.0);
  const auto ended = [](double n) { return n * 377.0 * kDegree + 0.31 * n * n * kDegree; };
  const double smooth = part * part * (3.0 - 2.0 * part);
  return 0.5 + ended(cycle) + smooth * (ended(cycle + 1.0) - ended(cycle));
}

/// As by_hand_rad, and let go: the wheel rolls back by 7 degrees.
double rocking_rad(double time_s) {
  const double standing_s = time_s - std::floor(time_s / kCycle_s) * kCycle_s - 5.0;
  const double let_go = std::clamp(standing_s, 0.0, 1.0);
  const double taken_up = std::clamp(2.0 * (-4.5 - standing_s), 0.0, 1.0);
  return by_hand_rad(time_s) - 7.0 * kDegree * (let_go + taken_up);
}

DatumReadings read_by_turning(const sim::PulseTrain& train, double datum_rad, int times) {
  DatumReadings readings({.pulses_per_turn = kTeeth});
  const auto edges = train.edges(0.0, times * kCycle_s);
  auto edge = edges.begin();
  for (int n = 0; n < times; ++n) {
    const double standing_s = (n + 1) * kCycle_s - 0.5;
    for (; edge != edges.end() && to_seconds(edge->time.time_since_epoch()) < standing_s; ++edge)
      readings.add(*edge);
    if (!readings.can_read()) continue;
    // Somebody reads whole degrees.
    const double shown = (train.angle_rad(standing_s) + datum_rad) / kDegree;
    readings.read(std::round(shown) * kDegree);
  }
  return readings;
}

TEST(DatumReadings, FindsTheDatumOfAWheelTurnedByHand) {
  for (const double datum_deg : {31.0, -140.0, 179.5}) {
    const DatumReadings readings =
        read_by_turning({.angle_rad = by_hand_rad, .teeth = kTeeth}, datum_deg * kDegree, 9);
    ASSERT_EQ(readings.readings(), 9U);
    const auto datum = readings.datum();
    ASSERT_TRUE(datum);
    const double off = std::remainder(datum->datum_rad - datum_deg * kDegree, kTurn) / kDegree;
    const double sigma = datum->sigma_rad / kDegree;
    std::printf("datum %g: off by %.2f +- %.2f deg\n", datum_deg, off, sigma);
    // A tooth comes every 3.75 degrees: 1.08 rms for one reading, and whole degrees.
    EXPECT_NEAR(sigma, std::sqrt(3.75 * 3.75 / 12.0 + 1.0 / 12.0) / 3.0, 0.1);
    EXPECT_LT(std::abs(off), 3.0 * sigma);
  }
}

TEST(DatumReadings, CountsTeethThatGoBackwards) {
  const auto datum =
      read_by_turning({.angle_rad = rocking_rad, .teeth = kTeeth, .second_track = true}, 0.5, 9).datum();
  ASSERT_TRUE(datum);
  EXPECT_LT(std::abs(datum->datum_rad - 0.5), 3.0 * datum->sigma_rad);
  EXPECT_LT(datum->sigma_rad, 0.5 * kDegree);
}

TEST(DatumReadings, KnowsWhereItStandsAfterASmallStepBack) {
  const double pitch_deg = 360.0 / kTeeth;
  // Teeth every 10 ns forward at -6, 4, 14 of the mark: the first one 0.4 pitches behind it.
  struct Case {
    std::vector<EdgeKind> steps;
    double stands;  ///< pitches behind the mark, in the middle of where it may
  };
  const auto forward = EdgeKind::kTooth, back = EdgeKind::kToothBackward;
  for (const Case& one : {Case{{}, 0.25},  // half of the unknown
                          {{forward}, 0.9},
                          {{forward, forward}, 1.9},
                          {{forward, forward, back}, 0.9},
                          {{forward, back}, -0.1},
                          {{forward, back, back}, -1.1},
                          {{forward, back, forward}, 0.9},
                          {{back}, -1.0}}) {
    DatumReadings readings({.pulses_per_turn = kTeeth});
    readings.add({node_time_from_ns(4), 0, EdgeKind::kTooth});
    readings.add({node_time_from_ns(10), 0, EdgeKind::kZeroMark});
    std::int64_t time_ns = 14;
    for (const EdgeKind step : one.steps) {
      readings.add({node_time_from_ns(time_ns), 0, step});
      time_ns += 10;
    }
    EXPECT_NEAR(readings.read(0.0) / kDegree, -one.stands * pitch_deg, 1e-9) << one.stands;
  }
}

TEST(DatumReadings, NeedsAMarkAndEveryToothSince) {
  DatumReadings readings({.pulses_per_turn = kTeeth});
  const auto edge = [](std::int64_t ns, EdgeKind kind) { return Edge{node_time_from_ns(ns), 0, kind}; };
  readings.add(edge(1, EdgeKind::kTooth));
  EXPECT_FALSE(readings.can_read());
  readings.add(edge(2, EdgeKind::kZeroMark));
  EXPECT_TRUE(readings.can_read());
  readings.add(edge(3, EdgeKind::kLost));
  EXPECT_FALSE(readings.can_read());
  readings.add(edge(4, EdgeKind::kZeroMark));
  readings.read(0.1);
  EXPECT_FALSE(readings.can_read()) << "the mark counts once";
  EXPECT_FALSE(readings.datum()) << "one reading has no scatter";
  readings.add(edge(5, EdgeKind::kToothBackward));
  readings.add(edge(6, EdgeKind::kZeroMark));
  EXPECT_FALSE(readings.can_read()) << "backwards the mark fires at its other end";
}

TEST(DatumReadings, TellsTheReadingThatIsOffAndTakesItBack) {
  DatumReadings readings({.pulses_per_turn = kTeeth});
  for (const double angle : {0.50, 0.51, 0.49, 1.50}) {
    readings.add({node_time_from_ns(2), 0, EdgeKind::kZeroMark});
    readings.read(angle);
  }
  EXPECT_NEAR(readings.datum()->worst_rad, 0.75, 0.03);
  readings.undo();
  EXPECT_LT(std::abs(readings.datum()->worst_rad), 0.011);
  // Readings that agree better than a tooth's width are no better than that.
  EXPECT_NEAR(readings.datum()->sigma_rad, kTurn / kTeeth / 6.0, 1e-9);
}

}  // namespace
}  // namespace roadbalance
