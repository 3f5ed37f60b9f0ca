#include "hil_tests/guest/ring_judge.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "common/bus/codec.hpp"
#include "firmware/epoch_packer.hpp"
#include "firmware/test/scripted_front_end.hpp"
#include "firmware/test/vehicle.hpp"

namespace roadbalance {
namespace {

constexpr int kTeeth = 96, kTurns = 60;
constexpr double kTurns_hz = 20.0, kRate_hz = 2000.0;
constexpr double kSeconds = (kTurns - 1) / kTurns_hz;
/// A pitch of the middle turns, when every angle is known.
constexpr std::size_t kMiddle = (kTurns / 2) * (kTeeth + 1) + 40;

/// The judge of rings on what is known to be right, and on what is known to be wrong.
class RingJudge : public ::testing::Test {
 protected:
  RingJudge() {
    vehicle.wheel[1].node = "";
    ring.encoder = vehicle.wheel[0].encoder;
    ring.filter = vehicle.filter;
    play();
  }
  /// As a device without fault reads it.
  void play() {
    std::vector<gpio_pulse_step> steps;
    ring.program.add_to(steps);
    edges.clear();
    for (const auto& step : test::in_order(steps))
      if (step.value == 1)
        edges.push_back({.time = node_time_from_ns(static_cast<std::int64_t>(step.t_ns)),
                         .kind = step.line == ring.program.mark ? EdgeKind::kZeroMark : EdgeKind::kTooth});
  }
  std::vector<ScanBlock> sealed() const {
    test::ScriptedFrontEnd device(
        test::marked_scans(0, static_cast<std::int64_t>(kSeconds * kRate_hz), kRate_hz), edges);
    std::vector<ScanBlock> blocks;
    pack_epoch(device, vehicle, vehicle.node[0], 1, [&](const SealedBlock& block) {
      if (block.kind == BlockKind::kScan) blocks.push_back(decode_scan(block));
    });
    return blocks;
  }
  static std::vector<ScanBlock> without_flags(std::vector<ScanBlock> blocks) {
    for (ScanBlock& block : blocks) block.quality = 0;
    return blocks;
  }
  /// The blocks of the later half: all angles are known before.
  static std::vector<ScanBlock> later_half(const std::vector<ScanBlock>& blocks) {
    return {blocks.begin() + std::ssize(blocks) / 2, blocks.end()};
  }
  test::AngleVerdict judge(const std::vector<ScanBlock>& blocks, double allowed_pitches = 0.0) const {
    return judge_angles(blocks, ring, [=](std::int64_t) { return allowed_pitches; });
  }

  VehicleConfig vehicle = test::one_node_vehicle(kRate_hz, kTeeth);
  test::JudgedRing ring{.program = {3, 4, kTeeth, kTurns_hz, 0, kTurns},
                        .line = 0,
                        .encoder = {},
                        .filter = {},
                        .machine_minus_monotonic_ns = 0};
  std::vector<Edge> edges;
};

TEST_F(RingJudge, FindsAWholeRingWhole) {
  const test::TurnVerdict turns = judge_turns(edges, ring);
  EXPECT_EQ(turns.whole, kTurns - 3);  // between marks; the first two only locate the ring
  EXPECT_EQ(turns.declared, 0);
  EXPECT_EQ(turns.silent, 0);
  const test::AngleVerdict angles = judge(sealed());
  EXPECT_GT(angles.right, static_cast<std::int64_t>(0.8 * kSeconds * kRate_hz));
  EXPECT_EQ(angles.silent_wrong, 0);
  EXPECT_EQ(angles.strict, angles.right);
  EXPECT_LT(angles.worst_silent_pitches, 0.1);
}

TEST_F(RingJudge, SeesThatATurnWithoutOneToothIsDeclared) {
  edges.erase(edges.begin() + kMiddle);
  const test::TurnVerdict turns = judge_turns(edges, ring);
  EXPECT_EQ(turns.declared, 1);
  EXPECT_EQ(turns.silent, 0);
  const test::AngleVerdict angles = judge(later_half(sealed()));
  EXPECT_EQ(angles.silent_wrong, 0);
  EXPECT_GT(angles.flagged, 0);
}

// The angle behind them is unknown until a mark has come, and flagged.
TEST_F(RingJudge, ReportsLostEdgesIfTheirFlagsAreTakenAway) {
  edges.erase(edges.begin() + kMiddle + 1, edges.begin() + kMiddle + 30);
  edges[kMiddle].kind = EdgeKind::kLost;
  EXPECT_EQ(judge_turns(edges, ring).declared, 1);
  const auto blocks = later_half(sealed());
  EXPECT_EQ(judge(blocks).silent_wrong, 0);
  const test::AngleVerdict angles = judge(without_flags(blocks));
  EXPECT_GT(angles.silent_wrong, 0) << angles.text();
  EXPECT_EQ(angles.flagged, 0);
}

// The node is configured for one ring, and another one turns.
TEST_F(RingJudge, ReportsTurnsWithoutAToothThatNobodyDeclares) {
  ring.program.teeth = kTeeth - 1;
  ring.encoder.pulses_per_turn = kTeeth - 1;
  play();
  ASSERT_EQ(judge_turns(edges, ring).whole, kTurns - 3);
  ring.program.teeth = kTeeth;
  const test::TurnVerdict turns = judge_turns(edges, ring);
  EXPECT_EQ(turns.whole, 0);
  EXPECT_EQ(turns.declared, 0);
  EXPECT_EQ(turns.silent, kTurns - 3);
}

TEST_F(RingJudge, ReportsAnglesThatAreOnePitchOff) {
  const auto later = std::chrono::nanoseconds(std::llround(1e9 / kTurns_hz / kTeeth));
  for (Edge& edge : edges) edge.time += later;
  const auto blocks = later_half(sealed());
  const test::AngleVerdict angles = judge(blocks);
  EXPECT_EQ(angles.right, 0) << angles.text();
  EXPECT_GT(angles.silent_wrong, 0);
  EXPECT_NEAR(angles.worst_silent_pitches, 1.0, 0.1);
}

TEST_F(RingJudge, SaysThatItJudgesNothingStrictlyWhereAPitchIsAllowed) {
  const auto blocks = later_half(sealed());
  EXPECT_GT(judge(blocks).strict, 0);
  EXPECT_EQ(judge(blocks, 1.0).strict, 0);
  const std::int64_t half = static_cast<std::int64_t>(1e9 * kSeconds * 0.75);
  const auto some = judge_angles(blocks, ring, [=](std::int64_t at_ns) { return at_ns < half ? 0.0 : 1.0; });
  EXPECT_GT(some.strict, 0);
  EXPECT_LT(some.strict, some.right);
}

/// A played line as a busy kernel reads it: its thread is late at times; of the edges that come meanwhile
/// the last one that waits gets the stamp of the thread's return, the others are lost.
std::vector<Edge> as_a_busy_kernel_reads(const std::vector<Edge>& edges, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> some(0.0, 1.0);
  const double often = std::pow(10.0, -3.0 + 2.0 * some(random)), latest_ns = 4e6 * some(random);
  struct Thread {
    NodeTime busy_until{};
    bool has_waiting = false;
  };
  std::map<EdgeKind, Thread> threads;
  std::vector<Edge> read;
  const auto take = [&](EdgeKind kind, NodeTime time) {
    read.push_back({.time = time, .kind = kind});
    const double busy_ns = some(random) < often ? latest_ns * some(random) : 5e3 + 5e4 * some(random);
    threads[kind] = {time + std::chrono::nanoseconds(std::llround(busy_ns)), false};
  };
  for (const Edge& edge : edges) {
    for (auto& [kind, thread] : threads)
      if (thread.has_waiting && thread.busy_until <= edge.time) take(kind, thread.busy_until);
    if (edge.time < threads[edge.kind].busy_until)
      threads[edge.kind].has_waiting = true;
    else
      take(edge.kind, edge.time);
  }
  std::ranges::stable_sort(read, {}, &Edge::time);
  return read;
}

// Teeth that are missing right before a mark are known by the teeth behind it.
TEST_F(RingJudge, SeesThatWhatABusyKernelLosesIsDeclared) {
  int whole = 0, declared = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const test::TurnVerdict turns = judge_turns(as_a_busy_kernel_reads(edges, seed), ring);
    EXPECT_EQ(turns.silent, 0) << "seed " << seed;
    whole += turns.whole;
    declared += turns.declared;
  }
  EXPECT_GT(whole, 1000);
  EXPECT_GT(declared, 1000);
}

}  // namespace
}  // namespace roadbalance
