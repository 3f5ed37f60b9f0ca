#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "common/angle/wheel_encoder.hpp"
#include "hil_tests/guest/gpio_rig.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
using test::hog_processor;
using test::PulseChip;

constexpr double kTurns_hz = 60.0;  // 300 km/h on a small wheel: 5.8 kHz of teeth
constexpr int kTeeth = 96, kTurns = 90;
constexpr unsigned kTooth = 3, kMark = 4;

/// A ring of 96 teeth with a zero mark at 60 turns a second for 1.5 s, through kernel and backend to sealed
/// blocks.
class GpioEncoder : public ::testing::Test {
 protected:
  GpioEncoder() {
    rig.vehicle.wheel[1].node = "";
    ring.begin_ns = PulseChip::now_ns() + test::kLead_ns;
    ring.add_to(steps);
    steps = test::in_order(std::move(steps));
  }

  std::int64_t middle_ns() const { return ring.begin_ns + static_cast<std::int64_t>(0.75e9); }
  double turns_at(NodeTime time) const { return ring.turns_at(to_ns(time) - rig.machine_minus_monotonic_ns); }
  std::vector<ScanBlock> seal() {
    test::Sealed sealed = rig.seal(ring.begin_ns, 1.45);
    faulty_turns = sealed.faulty_turns;
    return std::move(sealed.blocks);
  }
  /// Blocks that begin within [from, to) turns and have one of these bits.
  std::size_t flagged(const std::vector<ScanBlock>& blocks, double from, double to, std::int32_t bits) const {
    return static_cast<std::size_t>(std::ranges::count_if(blocks, [&](const ScanBlock& block) {
      const double at = turns_at(node_time_from_ns(block.header.time_ns));
      return at >= from && at < to && (block.quality & bits) != 0;
    }));
  }

  /// Blocks within two turns of the hole are flagged; those well before and after, whose turns have all their
  /// teeth, are not.
  void expect_only_the_hole_flagged(const std::vector<ScanBlock>& blocks) const {
    EXPECT_GE(faulty_turns, 1);
    EXPECT_EQ(flagged(blocks, 10.0, kHole - 2.0, kDoubtful), 0U);
    EXPECT_GE(flagged(blocks, kHole - 2.0, kHole + 2.0, kDoubtful), 1U);
    EXPECT_EQ(flagged(blocks, kHole + 4.0, kTurns, kDoubtful), 0U);
  }

  test::GpioRig rig{{{0, static_cast<int>(kTooth), {}, static_cast<int>(kMark)}}};
  std::vector<gpio_pulse_step> steps;
  test::RingProgram ring{kTooth, kMark, kTeeth, kTurns_hz, 0, kTurns};
  std::int64_t faulty_turns = 0;
  static constexpr std::int32_t kDoubtful = kQualityUncertainAngle0;
  static constexpr double kHole = kTurns_hz * 0.75;  ///< in turns, at middle_ns()
};

TEST_F(GpioEncoder, AFastRingGivesItsAngle) {
  rig.play(steps);
  EXPECT_EQ(rig.edges_of(EdgeKind::kTooth), static_cast<std::size_t>(kTurns * kTeeth));
  EXPECT_EQ(rig.edges_of(EdgeKind::kZeroMark), static_cast<std::size_t>(kTurns));
  WheelEncoder encoder(rig.vehicle.wheel[0].encoder);
  double worst_deg = 0.0;
  int known = 0;
  for (const Edge& edge : rig.edges) {
    encoder.add(edge.time, edge.kind);
    std::array<double, 1> angle;
    const NodeTime asked = edge.time - std::chrono::milliseconds(8);
    if (turns_at(asked) < 10.0 || edge.kind != EdgeKind::kZeroMark) continue;
    if (!encoder.angles(asked, 0.0, angle)) continue;
    ++known;
    worst_deg = std::max(
        worst_deg, std::abs(std::remainder(angle[0] - 2.0 * pi * turns_at(asked), 2.0 * pi)) * 180 / pi);
  }
  EXPECT_GE(known, kTurns - 15);
  // A microsecond of a stamp is 0.02 degrees here; the mark's phase is learnt from such stamps.
  EXPECT_LE(worst_deg, 0.05);
  EXPECT_EQ(encoder.faulty_turns(), 0);
  EXPECT_EQ(flagged(seal(), 10.0, kTurns, kDoubtful), 0U);
  std::printf("96 teeth at 60 turns/s: angle within %.4f degrees\n", worst_deg);
}

TEST_F(GpioEncoder, EdgesThatTheKernelHadNoRoomForMakeAFaultyTurnAndFlagItsBlocks) {
  const auto hog = hog_processor(48, middle_ns(), middle_ns() + 10'000'000);
  rig.play(steps);
  EXPECT_GE(rig.counted(DeviceCounter::kEdgesLost), 1);
  EXPECT_LT(rig.edges_of(EdgeKind::kTooth), static_cast<std::size_t>(kTurns * kTeeth - 20));
  const auto blocks = seal();
  expect_only_the_hole_flagged(blocks);
  EXPECT_GE(flagged(blocks, kHole - 2.0, kHole + 2.0, quality_no_reference(0)), 1U);
  std::printf("%zu teeth lost: %lld faulty turn(s)\n",
              static_cast<std::size_t>(kTurns * kTeeth) - rig.edges_of(EdgeKind::kTooth),
              static_cast<long long>(faulty_turns));
}

// Above the interrupt threads: the kernel merges edges, and nothing in its interface shows it.
TEST_F(GpioEncoder, EdgesThatTheKernelMergedAreFoundByCountingTeeth) {
  const auto hog = hog_processor(90, middle_ns(), middle_ns() + 1'000'000);
  rig.play(steps);
  EXPECT_EQ(rig.counted(DeviceCounter::kEdgesLost), 0);
  EXPECT_LT(rig.edges_of(EdgeKind::kTooth), static_cast<std::size_t>(kTurns * kTeeth - 2));
  expect_only_the_hole_flagged(seal());
}

}  // namespace
}  // namespace roadbalance
