#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/angle/wheel_encoder.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr double kTurns_hz = 18.0, kTurn_s = 1.0 / kTurns_hz;
constexpr EncoderConfig kRing{.pulses_per_turn = 96};

double angle_rad(double t) {
  return 2.0 * pi * kTurns_hz * t;
}
double seconds_of(NodeTime time) {
  return static_cast<double>(to_ns(time)) * 1e-9;
}

/// Feeds edges until an instant and compares the angle just before it with the truth.
class LossTest : public ::testing::Test {
 protected:
  void feed_until(double t) {
    for (; next < edges.size() && seconds_of(edges[next].time) < t; ++next)
      encoder.add(edges[next].time, edges[next].kind);
  }
  bool known(double t) const {
    std::array<double, 4> angle;
    const NodeTime first = node_time_from_ns(std::llround((t - 0.008) * 1e9));
    if (!encoder.angles(first, 1e5, angle)) return false;
    EXPECT_NEAR(std::remainder(angle[0] - truth(t - 0.008), 2.0 * pi), 0.0, 1e-3) << t;
    return true;
  }
  void declare(EdgeKind kind, double t) { encoder.add(node_time_from_ns(std::llround(t * 1e9)), kind); }

  std::function<double(double)> truth = angle_rad;
  std::vector<Edge> edges = sim::PulseTrain{.angle_rad = angle_rad}.edges(0.0, 4.0);
  std::size_t next = 0;
  WheelEncoder encoder{kRing};
};

// The zero mark passes at whole turns.
TEST_F(LossTest, ALostEdgeMakesItsTurnFaultyAndTheAngleUnknownUntilTheNextMark) {
  const double lost_s = 20.4 * kTurn_s;
  feed_until(lost_s);
  EXPECT_TRUE(known(lost_s));
  EXPECT_FALSE(encoder.uncertain());
  declare(EdgeKind::kLost, lost_s);
  declare(EdgeKind::kLost, lost_s);
  for (double t = lost_s; t < 20.98 * kTurn_s; t += 0.05 * kTurn_s) {
    feed_until(t);
    EXPECT_FALSE(known(t));
    EXPECT_TRUE(encoder.uncertain());
  }
  EXPECT_EQ(encoder.faulty_turns(), 1) << "one turn, however often it is said";
  feed_until(21.5 * kTurn_s);
  EXPECT_TRUE(known(21.5 * kTurn_s));
  EXPECT_TRUE(encoder.uncertain()) << "the last turn did not have its teeth";
  feed_until(22.3 * kTurn_s);  // a mark is judged once the teeth after it are there
  EXPECT_FALSE(encoder.uncertain());
  // Asked later, it reports the turns that were: the faulty one and the next.
  const auto at = [](double turns) { return node_time_from_ns(std::llround(turns * kTurn_s * 1e9)); };
  EXPECT_FALSE(encoder.uncertain(at(19.5), at(19.9)));
  EXPECT_TRUE(encoder.uncertain(at(19.5), at(20.1)));
  EXPECT_TRUE(encoder.uncertain(at(21.9), at(22.5)));
  EXPECT_FALSE(encoder.uncertain(at(22.01), at(22.5)));
  feed_until(40.0 * kTurn_s);
  EXPECT_EQ(encoder.faulty_turns(), 1);
}

TEST_F(LossTest, TeethThatAreLostBehindTheDeclarationDoNotShiftTheAngle) {
  const double lost_s = 20.4 * kTurn_s;
  std::erase_if(edges, [&](const Edge& edge) {
    const double t = seconds_of(edge.time);
    return edge.kind == EdgeKind::kTooth && t > lost_s && t < lost_s + 0.13 * kTurn_s;
  });
  feed_until(lost_s);
  declare(EdgeKind::kLost, lost_s);
  for (double t = lost_s; t < 60.0 * kTurn_s; t += 0.31 * kTurn_s) {
    feed_until(t);
    const bool is_known = known(t);  // and then right
    EXPECT_FALSE(is_known && t < 21.0 * kTurn_s) << t;
    EXPECT_TRUE(is_known || t < 21.5 * kTurn_s) << t;
  }
}

// Teeth and marks have lines of their own: one may be cut off.
TEST_F(LossTest, MarksWithoutTeethTellNoPlaceAndEveryTurnOfThemIsDoubtful) {
  const double cut_s = 20.4 * kTurn_s, back_s = 23.6 * kTurn_s;
  std::erase_if(edges, [&](const Edge& edge) {
    const double t = seconds_of(edge.time);
    return edge.kind == EdgeKind::kTooth && t > cut_s && t < back_s;
  });
  feed_until(cut_s);
  EXPECT_FALSE(encoder.uncertain());
  for (double t = 21.02 * kTurn_s; t < 24.0 * kTurn_s; t += 0.1 * kTurn_s) {
    feed_until(t);
    EXPECT_TRUE(encoder.uncertain()) << t;
    EXPECT_FALSE(known(t)) << t;
  }
  EXPECT_EQ(encoder.faulty_turns(), 1);
  for (double t = 24.5 * kTurn_s; t < 40.0 * kTurn_s; t += 0.37 * kTurn_s) {
    feed_until(t);
    EXPECT_TRUE(known(t)) << t;
  }
  EXPECT_FALSE(encoder.uncertain());
  EXPECT_EQ(encoder.faulty_turns(), 1);
}

TEST_F(LossTest, LossBeforeTheFirstMarkIsNoFaultyTurn) {
  declare(EdgeKind::kLost, 0.0);
  declare(EdgeKind::kToothBackward, 0.001);
  EXPECT_EQ(encoder.faulty_turns(), 0);
  feed_until(1.5);
  EXPECT_TRUE(known(1.5));
  EXPECT_EQ(encoder.faulty_turns(), 0);
}

// Forward, backward over several marks, forward again.
TEST_F(LossTest, BackwardsTheAngleIsRefusedUntilAMarkIsPassedForward) {
  const double back_s = 20.4 * kTurn_s, forth_s = 24.9 * kTurn_s;
  feed_until(back_s);
  // Mirrored: what came before the reversal comes again after it, teeth and marks.
  for (std::size_t k = next; k-- > 0;) {
    const double t = 2.0 * back_s - seconds_of(edges[k].time);
    if (t > forth_s) break;
    declare(edges[k].kind == EdgeKind::kTooth ? EdgeKind::kToothBackward : edges[k].kind, t);
    EXPECT_FALSE(known(t));
    EXPECT_TRUE(encoder.uncertain());
  }
  EXPECT_EQ(encoder.faulty_turns(), 1);
  // At 24.9 turns of time it stands at 15.9 turns and goes forward: the mark comes after a tenth of a turn.
  truth = [=](double t) { return angle_rad(t - forth_s + (2.0 * back_s - forth_s)); };
  edges = sim::PulseTrain{.angle_rad = truth}.edges(forth_s + 1e-4, forth_s + 2.0);
  next = 0;
  feed_until(forth_s + 0.08 * kTurn_s);
  EXPECT_FALSE(known(forth_s + 0.08 * kTurn_s));
  EXPECT_TRUE(encoder.uncertain());
  for (double t = forth_s + 0.7 * kTurn_s; t < forth_s + 1.9; t += 0.37 * kTurn_s) {
    feed_until(t);
    EXPECT_TRUE(known(t)) << t;
    EXPECT_EQ(encoder.uncertain(), t < forth_s + 1.1 * kTurn_s) << t;
  }
  EXPECT_EQ(encoder.faulty_turns(), 1);
}

}  // namespace
}  // namespace roadbalance
