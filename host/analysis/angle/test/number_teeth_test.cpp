#include "host/analysis/angle/number_teeth.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr int kTeeth = 96;
constexpr EncoderConfig kRing{.pulses_per_turn = kTeeth};
constexpr double kPitch_rad = 2.0 * pi / kTeeth;

double seconds_of(const Edge& edge) {
  return static_cast<double>(to_ns(edge.time)) * 1e-9;
}

class NumberTeeth : public ::testing::Test {
 protected:
  /// Every tooth has the number of the tooth that truly passed, but for whole turns.
  void expect_true_numbers(const NumberedTeeth& numbered) {
    std::size_t teeth = 0;
    for (const NumberedRun& run : numbered.runs)
      for (const NumberedTooth& tooth : run.teeth) {
        const double angle = train.angle_rad(static_cast<double>(tooth.time_ns) * 1e-9);
        const double off = (angle - train.first_tooth_rad) / kPitch_rad - static_cast<double>(tooth.number);
        ASSERT_LT(std::abs(std::remainder(off, kTeeth)), 0.5) << tooth.time_ns;
        ++teeth;
      }
    EXPECT_GT(teeth, edges.size() * 9 / 10);
  }
  /// The same of stamps that jitter by much of a pitch: in the mean of each turn.
  void expect_true_turns(const NumberedTeeth& numbered) {
    for (const NumberedRun& run : numbered.runs)
      for (std::size_t first = 0; first + kTeeth <= run.teeth.size(); first += kTeeth) {
        double sum = 0.0;
        for (std::size_t i = first; i < first + kTeeth; ++i) {
          const double angle = train.angle_rad(static_cast<double>(run.teeth[i].time_ns) * 1e-9);
          const double off =
              (angle - train.first_tooth_rad) / kPitch_rad - static_cast<double>(run.teeth[i].number);
          sum += std::remainder(off, kTeeth);
        }
        ASSERT_LT(std::abs(sum / kTeeth), 0.4) << run.teeth[first].time_ns;
      }
  }
  void drop(const std::function<bool(const Edge&)>& which) { std::erase_if(edges, which); }
  void add(double t, EdgeKind kind) {
    const Edge edge{node_time_from_ns(std::llround(t * 1e9)), 0, kind};
    edges.insert(std::ranges::upper_bound(edges, edge.time, {}, &Edge::time), edge);
  }
  static constexpr double kTurn_s = 1.0 / 18.0;

  sim::PulseTrain train{.angle_rad = [](double t) { return 2.0 * pi * 18.0 * t + 0.5 * std::sin(1.3 * t); },
                        .pitch_error_rad = sim::pitch_errors(kTeeth, 0.005, 3),
                        .jitter_s = 5e-6};
  std::vector<Edge> edges = train.edges(0.0, 6.0);
};

TEST_F(NumberTeeth, ACleanTrainIsOneRunWithoutFault) {
  const NumberedTeeth numbered = number_teeth(kRing, edges);
  ASSERT_EQ(numbered.runs.size(), 1U);
  EXPECT_TRUE(numbered.faulty_turns.empty());
  EXPECT_EQ(numbered.marks_dropped, 0);
  EXPECT_EQ(numbered.slips, 0);
  EXPECT_EQ(numbered.runs[0].marks_ns.size(), 108U);  // 6 s at 18 turns a second
  expect_true_numbers(numbered);
}

TEST_F(NumberTeeth, MarksMayBeMissingDoubledLateOrFalse) {
  int mark = 0;
  drop([&](const Edge& e) { return e.kind == EdgeKind::kZeroMark && (++mark % 4) == 0; });
  for (Edge& edge : edges)  // two late by five teeth
    if (edge.kind == EdgeKind::kZeroMark && (++mark % 40) == 0) edge.time += NodeClock::duration(2'900'000);
  std::ranges::stable_sort(edges, {}, &Edge::time);
  for (const double t : {1.013, 2.021, 2.5055, 4.7}) add(t, EdgeKind::kZeroMark);
  const NumberedTeeth numbered = number_teeth(kRing, edges);
  EXPECT_EQ(numbered.marks_dropped, 6);
  EXPECT_EQ(numbered.slips, 0);
  EXPECT_TRUE(numbered.faulty_turns.empty());
  expect_true_numbers(numbered);
}

TEST_F(NumberTeeth, ATurnWithoutExactlyItsTeethIsDeclared) {
  int tooth = 0;
  drop([&](const Edge& e) { return e.kind == EdgeKind::kTooth && ++tooth == 2000; });
  add(seconds_of(edges[5000]) + 0.0002, EdgeKind::kTooth);
  const NumberedTeeth numbered = number_teeth(kRing, edges);
  ASSERT_EQ(numbered.faulty_turns.size(), 2U);
  const auto lies_in = [&](double t, const NumberedTeeth::Turn& turn) {
    return static_cast<double>(turn.from_ns) * 1e-9 <= t && t <= static_cast<double>(turn.to_ns) * 1e-9;
  };
  EXPECT_TRUE(lies_in(2000.0 / kTeeth * kTurn_s, numbered.faulty_turns[0]));
  EXPECT_TRUE(lies_in(seconds_of(edges[5000]), numbered.faulty_turns[1]));
  expect_true_numbers(numbered);
}

// Half a turn of pulses squeezed, as by a burst of noise: the count goes wrong there and nowhere else.
TEST_F(NumberTeeth, ASlipOfTheCountDoesNotOutliveItsTurn) {
  const double from = 3.01, to = 3.03;
  drop([&](const Edge& e) {
    return e.kind == EdgeKind::kTooth && seconds_of(e) > from && seconds_of(e) < to;
  });
  for (int i = 0; i < 38; ++i) add(from + (i + 0.3) * (to - from) / 38.0, EdgeKind::kTooth);  // of 34.6
  const NumberedTeeth numbered = number_teeth(kRing, edges);
  EXPECT_GE(numbered.slips, 1);
  ASSERT_GE(numbered.faulty_turns.size(), 1U);
  for (const auto& turn : numbered.faulty_turns) {
    EXPECT_GT(static_cast<double>(turn.to_ns) * 1e-9, from);
    EXPECT_LT(static_cast<double>(turn.from_ns) * 1e-9, to);
  }
  expect_true_numbers(numbered);
}

// Errors of a fifth of a pitch and jitter of a sixth: without the table pulses are taken for their
// neighbours.
TEST_F(NumberTeeth, WithTheTableErrorsAndJitterTogetherDoNotShiftTheCount) {
  for (const std::uint64_t seed : {12U, 16U, 18U}) {
    train.pitch_error_rad =
        sim::with_eccentricity(sim::pitch_errors(kTeeth, 0.3 * pi / 180.0, 5), 0.5 * pi / 180.0, 0.4);
    train.jitter_s = 100e-6;
    train.seed = seed;
    edges = train.edges(0.0, 40.0);
    PitchTable table(kTeeth);
    const NumberedTeeth first = number_teeth(kRing, edges);
    ToothHistory history(edges.size());
    for (const NumberedTooth& tooth : first.runs.front().teeth) history.push(tooth);
    for (std::int64_t turn = 1; turn < 100; ++turn) table.learn(history, turn * kTeeth, 0);
    const NumberedTeeth second = number_again(kRing, edges, table, first);
    EXPECT_EQ(second.runs.size(), 1U);
    EXPECT_EQ(second.slips, 0);
    expect_true_turns(second);
  }
}

TEST_F(NumberTeeth, MarksThatJitterAreNoSlips) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> jitter_ns(0.0, 0.3 * kTurn_s / kTeeth * 1e9);
  for (Edge& edge : edges)
    if (edge.kind == EdgeKind::kZeroMark) edge.time += NodeClock::duration(std::llround(jitter_ns(random)));
  std::ranges::stable_sort(edges, {}, &Edge::time);
  const NumberedTeeth numbered = number_teeth(kRing, edges);
  EXPECT_EQ(numbered.slips, 0);
  EXPECT_LE(numbered.marks_dropped, 2);
  expect_true_numbers(numbered);
}

TEST_F(NumberTeeth, StandstillAndTurningBackEndARunAndTheNextIsAnchoredAnew) {
  // Forward 0.7 turns a second and back, then forward again.
  train.angle_rad = [](double t) {
    return t < 3.0 ? 40.0 * t : 120.0 + 40.0 * (t - 3.0) - 30.0 * std::min(t - 3.0, 1.0) * 2.0;
  };
  train.second_track = true;
  edges = train.edges(0.0, 8.0);
  const NumberedTeeth numbered = number_teeth(kRing, edges);
  ASSERT_EQ(numbered.runs.size(), 2U);
  for (const NumberedRun& run : numbered.runs)
    for (std::size_t i = 1; i < run.teeth.size(); ++i)
      ASSERT_GT(run.teeth[i].number, run.teeth[i - 1].number);
  edges = {};
  train.second_track = false;
  train.angle_rad = [](double t) { return t < 3.0 ? 60.0 * t : std::max(180.0, 60.0 * (t - 2.0)); };
  edges = train.edges(0.0, 8.0);
  const NumberedTeeth stopped = number_teeth(kRing, edges);
  EXPECT_EQ(stopped.runs.size(), 2U);
  expect_true_numbers(stopped);
}

TEST_F(NumberTeeth, ARingThatShouldHaveAZeroMarkHasNoNumbersWithoutOne) {
  drop([](const Edge& e) { return e.kind == EdgeKind::kZeroMark; });
  EXPECT_TRUE(number_teeth(kRing, edges).runs.empty());
  EXPECT_TRUE(number_teeth(kRing, {}).runs.empty());
}

TEST_F(NumberTeeth, ARingWithoutZeroMarkIsCountedFromAToothOfItsOwn) {
  drop([](const Edge& e) { return e.kind == EdgeKind::kZeroMark; });
  const NumberedTeeth numbered = number_teeth({.pulses_per_turn = kTeeth, .zero_mark = false}, edges);
  ASSERT_EQ(numbered.runs.size(), 1U);
  const std::vector<NumberedTooth>& teeth = numbered.runs[0].teeth;
  ASSERT_EQ(teeth.size(), edges.size());
  for (std::size_t i = 1; i < teeth.size(); ++i) ASSERT_EQ(teeth[i].number, teeth[i - 1].number + 1);
}

TEST_F(NumberTeeth, ASecondMarkAnywhereLeavesNoAngleAndIsNamed) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(1.5 / kTeeth, 1.0 - 1.5 / kTeeth);
  const std::vector<Edge> good = edges;
  for (int k = 0; k < 30; ++k) {
    edges = good;
    const double place = any(random);
    sim::PulseTrain second = train;
    second.angle_rad = [&](double t) { return train.angle_rad(t) - 2.0 * pi * place; };
    for (const Edge& edge : second.edges(0.0, 6.0))
      if (edge.kind == EdgeKind::kZeroMark) add(seconds_of(edge), EdgeKind::kZeroMark);
    const NumberedTeeth numbered = number_teeth(kRing, edges);
    EXPECT_TRUE(numbered.runs.empty()) << place;
    const auto [a, b] = numbered.mark_counts;
    EXPECT_TRUE(a + b == kTeeth || (b == 0 && 2 * a == kTeeth)) << a << " and " << b;
  }
}

TEST_F(NumberTeeth, ARingOfOtherTeethLeavesNoAngleAndIsNamed) {
  for (const int teeth : {95, 97, 100}) {
    train = {.angle_rad = train.angle_rad, .teeth = teeth, .jitter_s = 5e-6};
    const NumberedTeeth numbered = number_teeth(kRing, train.edges(0.0, 6.0));
    EXPECT_TRUE(numbered.runs.empty()) << teeth;
    EXPECT_EQ(numbered.mark_counts[0], teeth);
  }
}

TEST_F(NumberTeeth, AMarkEachSecondTurnIsRight) {
  int mark = 0;
  drop([&](const Edge& e) { return e.kind == EdgeKind::kZeroMark && (++mark % 2) == 0; });
  expect_true_numbers(number_teeth(kRing, edges));
}

}  // namespace
}  // namespace roadbalance
