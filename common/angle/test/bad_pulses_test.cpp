#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "common/angle/wheel_encoder.hpp"
#include "common/test/no_allocation.hpp"
#include "sim/pulse_train.hpp"

// Pulse trains as they are: what the angle is worth where marks and teeth are not as they should be.

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr int kTeeth = 96;
constexpr double kPitch_rad = 2.0 * pi / kTeeth, kTurns_hz = 18.0, kTurn_s = 1.0 / kTurns_hz;
constexpr double kBlock_s = 0.01;

NodeTime at(double seconds) {
  return node_time_from_ns(std::llround(seconds * 1e9));
}
double seconds_of(const Edge& edge) {
  return static_cast<double>(to_ns(edge.time)) * 1e-9;
}

/// Follows a train block by block as a node does, and keeps what the encoder reports for each.
class BadPulses : public ::testing::Test {
 protected:
  struct Block {
    double start_s;
    bool known, uncertain;
    double error_rad;  ///< largest
  };
  void follow(double to_s) {
    auto edge = edges.begin();
    std::array<double, 20> angle;
    for (double start = 0.0; start + 0.2 < to_s; start += kBlock_s) {
      const NodeTime last = at(start + kBlock_s);
      for (; edge != edges.end() && edge->time < encoder.complete_at(last); ++edge)
        encoder.add(edge->time, edge->kind);
      Block block{start, encoder.angles(at(start), 5e5, angle), encoder.uncertain(at(start), last), 0.0};
      for (std::size_t i = 0; block.known && i < angle.size(); ++i) {
        const double truth = train.angle_rad(start + 5e-4 * static_cast<double>(i));
        block.error_rad = std::max(block.error_rad, std::abs(std::remainder(angle[i] - truth, 2.0 * pi)));
      }
      blocks.push_back(block);
    }
  }
  int count(double from_s, double to_s, const std::function<bool(const Block&)>& which) const {
    return static_cast<int>(std::ranges::count_if(blocks, [&](const Block& block) {
      return block.start_s >= from_s && block.start_s < to_s && which(block);
    }));
  }
  int unknown(double from_s, double to_s) const {
    return count(from_s, to_s, [](const Block& block) { return !block.known; });
  }
  /// Blocks whose angle is wrong and that are not flagged.
  int silently_wrong(double from_s, double to_s, double tolerance_rad) const {
    return count(from_s, to_s, [&](const Block& block) {
      return block.known && !block.uncertain && block.error_rad > tolerance_rad;
    });
  }
  void add(double t, EdgeKind kind) {
    const Edge edge{at(t), 0, kind};
    edges.insert(std::ranges::upper_bound(edges, edge.time, {}, &Edge::time), edge);
  }

  sim::PulseTrain train{
      .angle_rad = [](double t) { return 2.0 * pi * kTurns_hz * t + 0.5 * std::sin(1.3 * t); },
      .pitch_error_rad = sim::pitch_errors(kTeeth, 0.005, 3),
      .jitter_s = 5e-6};
  std::vector<Edge> edges = train.edges(0.0, 10.0);
  WheelEncoder encoder{{.pulses_per_turn = kTeeth}};
  std::vector<Block> blocks;
};

TEST_F(BadPulses, ALateMarkIsNotBelieved) {
  int mark = 0;
  for (Edge& edge : edges)
    if (edge.kind == EdgeKind::kZeroMark && ++mark % 25 == 0) edge.time += NodeClock::duration(2'900'000);
  std::ranges::stable_sort(edges, {}, &Edge::time);
  follow(10.0);
  EXPECT_EQ(unknown(0.3, 10.0), 0);
  EXPECT_EQ(count(0.3, 10.0, [](const Block& b) { return b.error_rad > 0.1 * kPitch_rad; }), 0);
  EXPECT_EQ(encoder.faulty_turns(), 7);  // 180 turns
}

TEST_F(BadPulses, EveryMarkDoubledIsAFaultButNoError) {
  std::vector<Edge> doubled;
  for (const Edge& edge : edges) {
    doubled.push_back(edge);
    if (edge.kind == EdgeKind::kZeroMark)
      doubled.push_back({edge.time + NodeClock::duration(300'000), 0, EdgeKind::kZeroMark});
  }
  std::ranges::stable_sort(doubled, {}, &Edge::time);
  edges = doubled;
  follow(10.0);
  EXPECT_EQ(unknown(0.3, 10.0), 0);
  EXPECT_EQ(count(0.3, 10.0, [](const Block& b) { return b.error_rad > 0.15 * kPitch_rad; }), 0);
  EXPECT_GT(encoder.faulty_turns(), 170);
}

TEST_F(BadPulses, ASqueezedTurnIsPutRightAtTheNextMarkAndFlagged) {
  const double from = 5.01, to = 5.03;
  std::erase_if(edges, [&](const Edge& e) {
    return e.kind == EdgeKind::kTooth && seconds_of(e) > from && seconds_of(e) < to;
  });
  for (int i = 0; i < 38; ++i) add(from + (i + 0.3) * (to - from) / 38.0, EdgeKind::kTooth);  // of 34.6
  follow(10.0);
  EXPECT_EQ(silently_wrong(0.3, 10.0, 0.15 * kPitch_rad), 0);
  EXPECT_EQ(unknown(5.3, 10.0), 0);
  EXPECT_EQ(count(5.3, 10.0, [](const Block& b) { return b.error_rad > 0.15 * kPitch_rad || b.uncertain; }),
            0);
  EXPECT_GE(encoder.faulty_turns(), 1);
}

TEST_F(BadPulses, ParkingCreepBackAndForthIsRefusedOrRight) {
  // Rolls out within 2 s, rocks a third of a turn back and forth, stands, creeps, drives off.
  train.angle_rad = [](double t) {
    if (t < 2.0) return 60.0 * t - 15.0 * t * t;
    if (t < 5.0) return 60.0 + 2.0 * std::sin(2.1 * (t - 2.0));
    if (t < 6.0) return 60.0 + 2.0 * std::sin(6.3);
    return 60.0 + 2.0 * std::sin(6.3) + 12.0 * (t - 6.0) * (t - 6.0);
  };
  train.second_track = true;
  edges = train.edges(0.0, 10.0);
  follow(10.0);
  EXPECT_EQ(silently_wrong(0.0, 10.0, 0.5 * kPitch_rad), 0);
  EXPECT_EQ(unknown(2.8, 3.5), count(2.8, 3.5, [](const Block&) { return true; })) << "backwards";
  EXPECT_EQ(unknown(5.2, 5.9), count(5.2, 5.9, [](const Block&) { return true; })) << "at a stand";
  EXPECT_EQ(unknown(7.5, 9.7), 0);
  EXPECT_EQ(count(7.5, 9.7, [](const Block& b) { return b.error_rad > 0.2 * kPitch_rad; }), 0);
}

TEST_F(BadPulses, StampsAsBadAsASixthOfAPitchDoNotShiftTheCount) {
  train.jitter_s = 100e-6;
  edges = train.edges(0.0, 10.0);
  follow(10.0);
  EXPECT_EQ(unknown(0.5, 10.0), 0);
  // 100 us are 0.65 degrees; after a few turns of learning no angle is half a pitch off.
  EXPECT_EQ(count(2.0, 10.0, [](const Block& b) { return b.error_rad > 0.3 * kPitch_rad; }), 0);
}

// A stamp that leaves its tooth's gate is missing there and too many beside: the turn has its teeth.
TEST_F(BadPulses, ATurnWithExactlyItsTeethIsNoFaultHoweverTheyJitter) {
  train.jitter_s = 100e-6;
  edges = train.edges(0.0, 10.0);
  follow(10.0);
  EXPECT_LT(count(2.0, 10.0, [](const Block& b) { return b.uncertain; }), 800 / 20);
}

TEST_F(BadPulses, OneToothLessOrMoreIsAFaultHoweverTheyJitter) {
  train.jitter_s = 100e-6;
  edges = train.edges(0.0, 10.0);
  const auto tooth_after = [&](double t) {
    return std::ranges::find_if(
        edges, [&](const Edge& e) { return seconds_of(e) > t && e.kind == EdgeKind::kTooth; });
  };
  edges.erase(tooth_after(4.0));
  add(0.5 * (seconds_of(*tooth_after(7.0)) + seconds_of(*tooth_after(7.0003))), EdgeKind::kTooth);
  follow(10.0);
  for (const double fault : {4.0, 7.0})  // the turn after the one with the fault is doubtful too
    EXPECT_EQ(count(fault, fault + 0.9 * kTurn_s, [](const Block& b) { return !b.uncertain; }), 0) << fault;
}

// Marks that jitter by a sixth of a pitch: one that is off by more than half a pitch is no slip.
TEST_F(BadPulses, ASlipIsToldFromMarksThatJitter) {
  train.jitter_s = 100e-6;
  edges = train.edges(0.0, 20.0);
  // From 8 s on the count is off by one: a tooth too many, as long as all the others of half a turn.
  const double from = 8.01, to = 8.03;
  std::erase_if(edges, [&](const Edge& e) {
    return e.kind == EdgeKind::kTooth && seconds_of(e) > from && seconds_of(e) < to;
  });
  for (int i = 0; i < 36; ++i) add(from + (i + 0.3) * (to - from) / 36.0, EdgeKind::kTooth);  // of 34.6
  follow(20.0);
  EXPECT_EQ(silently_wrong(2.0, 20.0, 0.5 * kPitch_rad), 0);
  EXPECT_EQ(count(9.0, 20.0, [](const Block& b) { return b.error_rad > 0.3 * kPitch_rad; }), 0);
}

TEST_F(BadPulses, NeverAllocates) {
  std::array<double, 20> angle;
  const test::NoAllocation guard;
  auto edge = edges.begin();
  for (double start = 0.0; start < 5.0; start += kBlock_s) {
    for (; edge != edges.end() && edge->time < at(start + 0.08); ++edge) encoder.add(edge->time, edge->kind);
    static_cast<void>(encoder.angles(at(start), 5e5, angle));
  }
}

}  // namespace
}  // namespace roadbalance
