#include "host/analysis/identify/assemble.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

const VehicleConfig& car() {
  static const VehicleConfig vehicle = VehicleConfig::read_file(test::source_path("sim/demo/vehicle.toml"));
  return vehicle;
}

constexpr std::int64_t kPeriodNs = 500'000;

/// Block `number` of one node.  Every sensor reads what z''(k) = (k + 1) * unit 0.01 m/s^2 in heave and all
/// wheels would give, and the references the angle k / 100 of every wheel.
SealedBlock block_of(int node_index, std::int64_t number, std::int32_t quality = 0,
                     std::int64_t offset_ns = 0, std::int32_t overload = 0) {
  const NodeConfig& node = car().node[static_cast<std::size_t>(node_index)];
  ScanBlock block;
  block.header = {node.id,        1,
                  number + 1,     number * kScansPerBlock,
                  kScansPerBlock, number * kScansPerBlock * kPeriodNs + offset_ns};
  block.period_ps = kPeriodNs * 1000;
  block.quality = quality;
  block.overload = overload;
  for (int row = 0; row < kScansPerBlock; ++row) {
    const double k = static_cast<double>(number * kScansPerBlock + row);
    auto& counts = block.counts[static_cast<std::size_t>(row)];
    for (std::size_t c = 0; c < node.channel.size(); ++c)
      counts[c] = static_cast<std::int32_t>(
          std::lround(0.01 * (k + 1) * node.channel[c].direction.z() / node.channel[c].scale_m_s2_per_count));
    for (std::size_t line = 0; line < kEncoderLines; ++line) {
      counts[kAccelerations + 2 * line] =
          static_cast<std::int32_t>(std::lround(kFullScaleCounts * std::sin(k / 100)));
      counts[kAccelerations + 2 * line + 1] =
          static_cast<std::int32_t>(std::lround(kFullScaleCounts * std::cos(k / 100)));
    }
  }
  SealedBlock sealed;
  seal(block, sealed);
  return sealed;
}

std::vector<SignalRun> assemble(const std::vector<SealedBlock>& blocks) {
  std::vector<SignalRun> runs;
  Assembler assembler(car(), [&](const SignalRun& run) { runs.push_back(run); });
  for (const auto& block : blocks) assembler.consume(block);
  return runs;
}

TEST(Assembler, GivesTheSevenAccelerationsAndAllAngles) {
  const auto runs = assemble({block_of(0, 0), block_of(1, 0)});
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_TRUE(runs[0].restart);
  ASSERT_EQ(runs[0].samples.cols(), kScansPerBlock);
  for (int k = 0; k < kScansPerBlock; ++k) {
    SignalVector expected = SignalVector::Zero();
    expected(0) = 0.01 * (k + 1);  // heave; no roll, no pitch
    expected.segment<kWheels>(kBodyCoordinates).setConstant(0.01 * (k + 1));
    for (int w = 0; w < kWheels; ++w) {
      expected(cosine_row(w)) = std::cos(k / 100.0);
      expected(sine_row(w)) = std::sin(k / 100.0);
    }
    // A count is 2.4e-5 m/s^2 of a wheel.
    EXPECT_LT((runs[0].samples.col(k) - expected).cwiseAbs().maxCoeff(), 3e-5) << k;
  }
}

TEST(Assembler, TakesOffByHowMuchAChannelLags) {
  const std::size_t lagging = 2;  // fl_carrier_z
  VehicleConfig vehicle = car();
  vehicle.node[0].channel[lagging].delay_s = 1.2e-3;
  std::vector<SignalRun> runs;
  Assembler assembler(vehicle, [&](const SignalRun& run) { runs.push_back(run); });
  const double lag_counts =
      0.01 * 1.2e-3 / (1e-9 * kPeriodNs) / car().node[0].channel[lagging].scale_m_s2_per_count;
  for (int number = 0; number < 5; ++number) {
    ScanBlock late = decode_scan(block_of(0, number));
    for (auto& row : late.counts) row[lagging] -= static_cast<std::int32_t>(std::lround(lag_counts));
    SealedBlock sealed;
    seal(late, sealed);
    assembler.consume(sealed);
    assembler.consume(block_of(1, number));
  }
  Eigen::Index rows = 0;
  for (const SignalRun& run : runs)
    for (Eigen::Index i = 0; i < run.samples.cols(); ++i, ++rows) {
      const double k = static_cast<double>(run.first_index + i);
      // Two counts of 2.4e-5 m/s^2 are rounded.
      EXPECT_NEAR(run.samples(kBodyCoordinates, i), 0.01 * (k + 1), 6e-5) << k;
      EXPECT_NEAR(run.samples(sine_row(0), i), std::sin(k / 100), 1e-6) << k;
    }
  EXPECT_EQ(rows, 100 - 13 - 18);
}

TEST(Assembler, LeavesOutBlocksInWhichASensorIsClippedAndTellsThatWhatWasBeforeIsSpoiled) {
  constexpr std::size_t kCut = 2;  // fl_carrier_z
  constexpr double kLimit_m_s2 = 12.0;
  const double scale = car().node[0].channel[kCut].scale_m_s2_per_count;
  std::vector<SignalRun> runs;
  Assembler assembler(car(), [&](const SignalRun& run) { runs.push_back(run); });
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  double value = 0.0, speed = 0.0;  // a resonance at 15 Hz, a tenth of critically damped, 6 m/s^2 rms
  for (std::int64_t number = 0; number < 3000; ++number) {
    ScanBlock block = decode_scan(block_of(0, number));
    for (auto& row : block.counts) {
      constexpr double kOmega = 2.0 * std::numbers::pi * 15.0 * 1e-9 * kPeriodNs;
      speed += -0.2 * kOmega * speed - kOmega * kOmega * value + 0.04 * normal(random);
      value += speed;
      row[kCut] = static_cast<std::int32_t>(std::clamp(value, -kLimit_m_s2, kLimit_m_s2) / scale);
    }
    SealedBlock sealed;
    seal(block, sealed);
    assembler.consume(sealed);
    assembler.consume(block_of(1, number));
  }
  // One side becomes known before the other.
  const auto first = std::ranges::find(runs, true, &SignalRun::spoiled);
  ASSERT_NE(first, runs.end());
  const auto spoiled = std::find_if(first + 1, runs.end(), [](const SignalRun& run) { return run.spoiled; });
  ASSERT_NE(spoiled, runs.end());
  EXPECT_EQ(std::ranges::count(runs, true, &SignalRun::spoiled), 2);
  EXPECT_TRUE(first->restart && spoiled->restart);
  const auto peak = [](auto from, auto to) {
    double most = 0.0;
    for (; from != to; ++from)
      most = std::max(most, from->samples.row(kBodyCoordinates).cwiseAbs().maxCoeff());
    return most;
  };
  EXPECT_NEAR(peak(runs.begin(), first), kLimit_m_s2, 1e-3) << "nothing was known then";
  EXPECT_LT(peak(spoiled, runs.end()), 0.99 * kLimit_m_s2);
  EXPECT_GT(std::distance(spoiled, runs.end()), 1000) << "the others are used";
  const auto clipped = assembler.clipped();
  ASSERT_EQ(clipped.size(), 1U);
  EXPECT_EQ(clipped[0].find("fl_carrier_z is clipped at "), 0U) << clipped[0];
}

TEST(Assembler, ResultDoesNotDependOnHowNodesInterleave) {
  std::vector<SealedBlock> in_turn, one_after_the_other;
  for (int number = 0; number < 6; ++number)
    for (int node = 0; node < 2; ++node) in_turn.push_back(block_of(node, number));
  for (int node = 0; node < 2; ++node)
    for (int number = 0; number < 6; ++number) one_after_the_other.push_back(block_of(node, number));
  const auto a = assemble(in_turn), b = assemble(one_after_the_other);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].first_index, b[i].first_index);
    EXPECT_EQ(a[i].samples, b[i].samples);
  }
}

TEST(Assembler, RunsRestartAfterWhatIsMissing) {
  for (const std::int32_t overload :
       {1 << 2, 0}) {  // a block with overload of a vertical channel, and one never sent
    std::vector<SealedBlock> blocks;
    for (int number = 0; number < 4; ++number) {
      blocks.push_back(block_of(0, number));
      if (number != 2 || overload != 0)
        blocks.push_back(block_of(1, number, 0, 0, number == 2 ? overload : 0));
    }
    const auto runs = assemble(blocks);
    ASSERT_EQ(runs.size(), 3U);
    EXPECT_FALSE(runs[1].restart);
    EXPECT_TRUE(runs[2].restart);
    EXPECT_EQ(runs[2].first_index, 3 * kScansPerBlock);
  }
}

TEST(Assembler, AWheelWithoutAngleLeavesTheOthersAlone) {
  const auto runs = assemble({block_of(0, 0), block_of(1, 0, kQualityNoReference1)});
  ASSERT_EQ(runs.size(), 1U);
  for (int w = 0; w < kWheels; ++w)  // line 1 of the second node is rear_right
    EXPECT_NEAR(std::abs(reference(runs[0].samples.col(5), w)), w == 3 ? 0.0 : 1.0, 1e-6) << w;
}

TEST(Assembler, ANodeThatStaysAwayDoesNotHoldTheOthersBack) {
  constexpr std::int64_t longest = 3000;  // blocks of 10 ms
  std::vector<SignalRun> runs;
  Assembler assembler(
      car(), [&](const SignalRun& run) { runs.push_back(run); }, longest * 0.01);
  for (std::int64_t number = 0; number < longest + 500; ++number) assembler.consume(block_of(0, number));
  assembler.consume(block_of(1, 100));            // comes too late: what it would meet is gone
  assembler.consume(block_of(1, longest + 400));  // meets its neighbour
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0].first_index, (longest + 400) * kScansPerBlock);
}

TEST(Assembler, NodesThatBeginApartMeetAtTheFirstCommonScan) {
  std::vector<SealedBlock> blocks{block_of(0, 0), block_of(0, 1)};
  blocks.push_back(block_of(1, 0, 0, 7 * kPeriodNs));  // began seven scans later
  const auto runs = assemble(blocks);
  ASSERT_FALSE(runs.empty());
  EXPECT_EQ(runs[0].first_index, 7);
  EXPECT_EQ(runs[0].samples.cols(), kScansPerBlock - 7);
}

TEST(Assembler, BringsToTheGridWhatLiesBesideItAndNamesWhatCannotBe) {
  std::vector<SignalRun> runs;
  Assembler assembler(car(), [&](const SignalRun& run) { runs.push_back(run); });
  for (int number = 0; number < 5; ++number) {
    assembler.consume(block_of(0, number));
    assembler.consume(block_of(1, number, 0, kPeriodNs / 3));
  }
  EXPECT_TRUE(assembler.no_common_time().empty());
  ASSERT_FALSE(runs.empty());
  EXPECT_EQ(runs[0].first_index, 16);  // the filter needs 16 samples of the node beside the grid first
  for (const SignalRun& run : runs)
    for (Eigen::Index i = 0; i < run.samples.cols(); ++i) {
      const double k = static_cast<double>(run.first_index + i);
      EXPECT_NEAR(run.samples(kBodyCoordinates, i), 0.01 * (k + 1), 3e-5);  // front left
      // The second node's samples were taken a third of a period later: between them it is that of earlier.
      EXPECT_NEAR(run.samples(kBodyCoordinates + 3, i), 0.01 * (k + 1 - 1.0 / 3.0), 3e-5);
      EXPECT_NEAR(run.samples(sine_row(3), i), std::sin((k - 1.0 / 3.0) / 100), 1e-6);
    }
  ScanBlock other;
  other.header = {car().node[1].id, 7, 1, 0, kScansPerBlock, 0};
  other.period_ps = 600'000'000;
  SealedBlock sealed;
  seal(other, sealed);
  assembler.consume(sealed);
  EXPECT_NE(assembler.no_common_time().find("node 2"), std::string::npos) << assembler.no_common_time();
}

TEST(Assembler, ClocksOfTheirOwnMeetByTheirFits) {
  std::vector<SignalRun> runs;
  Assembler assembler(car(), [&](const SignalRun& run) { runs.push_back(run); });
  constexpr std::int64_t kAhead_ns = 12'345'678'901;  // no multiple of a period
  for (int n = 0; n < 2; ++n)
    assembler.consume(ClockFit{.node = car().node[static_cast<std::size_t>(n)].id,
                               .epoch = 1,
                               .state = ClockState::kLocked,
                               .host_ns = 1000,
                               .node_ns = 1000 + n * kAhead_ns});
  for (int number = 0; number < 5; ++number)
    for (int n = 0; n < 2; ++n) assembler.consume(block_of(n, number, 0, n * kAhead_ns));
  ASSERT_FALSE(runs.empty());
  Eigen::Index columns = 0;
  for (const SignalRun& run : runs)
    for (Eigen::Index i = 0; i < run.samples.cols(); ++i, ++columns)
      for (int wheel = 0; wheel < kWheels; ++wheel)
        EXPECT_NEAR(run.samples(kBodyCoordinates + wheel, i),
                    0.01 * static_cast<double>(run.first_index + i + 1), 3e-5);
  EXPECT_EQ(columns, 5 * kScansPerBlock - 31);
}

}  // namespace
}  // namespace roadbalance
