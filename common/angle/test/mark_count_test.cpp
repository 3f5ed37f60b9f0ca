#include "common/angle/mark_count.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "common/angle/wheel_encoder.hpp"
#include "sim/pulse_train.hpp"

// Marks that name no tooth give no angle, and are named by the teeth between them.
namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr int kTeeth = 96;

TEST(MarkCount, TrustsMarksAWholeTurnApart) {
  MarkCount count(kTeeth);
  count.add(10.3);
  EXPECT_FALSE(count.trusted()) << "one mark may be any";
  count.add(106.4);
  EXPECT_TRUE(count.trusted());
  count.add(3 * kTeeth + 10.2);
  EXPECT_TRUE(count.trusted()) << "one was missed";
  count.forget();
  EXPECT_TRUE(count.trusted()) << "lost teeth say nothing of the marks";
}

TEST(MarkCount, IsNotDeceivedByMarksThatFailNowAndThen) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  std::normal_distribution<double> jitter(0.0, 0.2);
  MarkCount count(kTeeth);
  double slip = 0.0;
  for (int turn = 0; turn < 2000; ++turn) {
    if (any(random) < 0.03) slip += any(random) < 0.5 ? 1.0 : -1.0;
    if (any(random) > 0.1) count.add(kTeeth * turn + slip + jitter(random));
    if (any(random) < 0.1) count.add(kTeeth * (turn + any(random)) + slip);
    ASSERT_TRUE(turn < 2 || count.trusted()) << turn;
  }
}

TEST(MarkCount, DistrustsWhatBeginsInTheMiddleOfADriveAndTrustsAgain) {
  MarkCount count(kTeeth);
  for (int turn = 0; turn < 20; ++turn) count.add(kTeeth * turn);
  for (int turn = 20; turn < 32; ++turn) {
    count.add(kTeeth * turn);
    count.add(kTeeth * turn + 30);
  }
  EXPECT_FALSE(count.trusted());
  std::array<int, 2> counts = count.counts();
  std::ranges::sort(counts);
  EXPECT_EQ(counts, (std::array{30, 66}));
  for (int turn = 32; turn < 47; ++turn) count.add(kTeeth * turn);
  EXPECT_TRUE(count.trusted());
  EXPECT_EQ(count.counts(), (std::array{0, 0}));
}

/// Edges of a ring of so many teeth, with further marks at these shares of a turn.
std::vector<Edge> edges_of(int teeth, const std::vector<double>& marks_turns, double first_tooth,
                           unsigned seed, bool every_second_turn = false) {
  const auto angle = [](double t) { return 2.0 * pi * 9.0 * t + 0.8 * std::sin(2.0 * pi * 0.21 * t) + 1.0; };
  const double pitch = 2.0 * pi / teeth;
  const sim::PulseTrain ring{.angle_rad = angle,
                             .teeth = teeth,
                             .pitch_error_rad = sim::pitch_errors(teeth, 0.005, seed),
                             .first_tooth_rad = first_tooth * pitch,
                             .jitter_s = 5e-6,
                             .seed = seed};
  std::vector<Edge> edges;
  for (const Edge& edge : ring.edges(0.0, 6.0))
    if (edge.kind == EdgeKind::kTooth) edges.push_back(edge);
  for (const double at : marks_turns) {
    const auto turned = [&](double t) { return angle(t) - 2.0 * pi * at; };
    const sim::PulseTrain mark{.angle_rad = turned, .teeth = 4, .jitter_s = 5e-6, .seed = seed + 1};
    int turn = 0;
    for (const Edge& edge : mark.edges(0.0, 6.0))
      if (edge.kind == EdgeKind::kZeroMark && (!every_second_turn || turn++ % 2 == 0)) edges.push_back(edge);
  }
  std::ranges::stable_sort(edges, {}, &Edge::time);
  return edges;
}

struct Outcome {
  int angles = 0;
  double worst_deg = 0.0;  ///< against the first mark's
  std::array<int, 2> counts{};
};

Outcome follow(const std::vector<Edge>& edges) {
  WheelEncoder encoder({.pulses_per_turn = kTeeth, .zero_mark = true});
  Outcome outcome;
  std::array<double, 1> angle;
  std::int64_t asked_ns = 0;
  for (const Edge& edge : edges) {
    encoder.add(edge.time, edge.kind);
    const std::int64_t now_ns = to_ns(edge.time) - 50'000'000;
    if (now_ns < asked_ns + 10'000'000) continue;
    asked_ns = now_ns;
    if (!encoder.angles(node_time_from_ns(now_ns), 1.0, angle)) continue;
    const double t = 1e-9 * static_cast<double>(now_ns);
    const double truth = 2.0 * pi * 9.0 * t + 0.8 * std::sin(2.0 * pi * 0.21 * t) + 1.0;
    ++outcome.angles;
    outcome.worst_deg =
        std::max(outcome.worst_deg, std::abs(std::remainder(angle[0] - truth, 2.0 * pi)) * 180.0 / pi);
  }
  outcome.counts = encoder.mark_counts();
  return outcome;
}

TEST(MarkCount, ASecondMarkAnywhereGivesNoAngleOrTheRightOne) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const double second = any(random), first_tooth = any(random);
    const Outcome found = follow(edges_of(kTeeth, {0.0, second}, first_tooth, seed));
    const double apart = kTeeth * std::abs(std::remainder(second, 1.0));
    if (apart > 1.0) {
      EXPECT_EQ(found.angles, 0) << second << ", off by " << found.worst_deg << " deg";
      EXPECT_NEAR(found.counts[0] + found.counts[1], kTeeth, 2)
          << found.counts[0] << " and " << found.counts[1];
    } else {
      EXPECT_LT(found.worst_deg, 360.0 / kTeeth) << "within a tooth of it";
    }
  }
}

TEST(MarkCount, OppositeMarksAreNamedByHalfTheTeeth) {
  const Outcome found = follow(edges_of(kTeeth, {0.0, 0.5}, 0.4, 3));
  EXPECT_EQ(found.angles, 0);
  EXPECT_EQ(found.counts[0], kTeeth / 2);
}

TEST(MarkCount, AMarkEachSecondTurnIsRight) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Outcome found = follow(edges_of(kTeeth, {0.0}, any(random), seed, true));
    EXPECT_GT(found.angles, 300);
    EXPECT_LT(found.worst_deg, 0.5);
  }
}

TEST(MarkCount, ARingOfOtherTeethGivesNoAngle) {
  for (const int teeth : {95, 97, 94, 48, 100}) {
    const Outcome found = follow(edges_of(teeth, {0.0}, 0.3, 5));
    EXPECT_EQ(found.angles, 0) << teeth;
    EXPECT_EQ(found.counts[0], teeth);
  }
}

TEST(MarkCount, AGoodRingIsRight) {
  const Outcome found = follow(edges_of(kTeeth, {0.0}, 0.3, 6));
  EXPECT_GT(found.angles, 500);
  EXPECT_LT(found.worst_deg, 0.5);
  EXPECT_EQ(found.counts[0], 0);
}

}  // namespace
}  // namespace roadbalance
