#include "host/analysis/calibration/loop_back_comparison.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>

#include "common/bus/codec.hpp"
#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "firmware/epoch_packer.hpp"
#include "sim/front_end.hpp"

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
using Cause = LoopBackComparison::Cause;
using Row = std::array<std::int32_t, kChannels>;

VehicleConfig car(FilterConfig filter = {6, 200.0}, double datum_deg = 30.0) {
  VehicleConfig vehicle = VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "car");
  vehicle.filter = filter;
  vehicle.wheel[0].encoder.datum_rad = datum_deg * kDegree;
  vehicle.node[0].wiring.loop_back = true;
  return vehicle;
}

/// A minute of the simulated car's front node, `fitted`; its record is described as `described`.
std::vector<SealedBlock> drive(const VehicleConfig& fitted, const VehicleConfig& described,
                               const std::string& more = "") {
  const test::TemporaryDirectory folder;
  const std::string scenario = folder / "scenario.toml";
  std::ofstream(scenario) << (more.empty() ? test::read_source("sim/demo/scenario.toml") : more);
  const auto device =
      sim::open_sim_front_end({scenario + "?seed=5&seconds=60&rate=max", fitted, fitted.node[0]});
  std::vector<SealedBlock> blocks;
  pack_epoch(*device, described, described.node[0], 9,
             [&](const SealedBlock& block) { blocks.push_back(block); });
  return blocks;
}

const std::vector<SealedBlock>& right_drive() {
  static const std::vector<SealedBlock> blocks = drive(car(), car());
  return blocks;
}

/// @param wires  what wrong wires make of a row
std::array<LoopBackComparison::Verdict, 2> compare(const std::vector<SealedBlock>& blocks,
                                                   const std::function<void(Row&)>& wires = {},
                                                   const VehicleConfig& vehicle = car()) {
  ComputedReferences computed(vehicle, vehicle.node[0]);
  for (const SealedBlock& block : blocks) computed.learn(block);
  LoopBackComparison comparison(vehicle.node[0].rate_hz);
  for (const SealedBlock& sealed : blocks) {
    if (sealed.kind != BlockKind::kScan) continue;
    ScanBlock block = decode_scan(sealed);
    if (wires) std::ranges::for_each(block.counts, wires);
    comparison.add(block, computed.of(block));
  }
  return {comparison.verdict(0, 0.1 * kDegree), comparison.verdict(1, 0.1 * kDegree)};
}

TEST(LoopBackComparison, AgreesToATwohundredthOfADegreeForAnyFilter) {
  for (const FilterConfig filter : {FilterConfig{6, 200.0}, {4, 100.0}, {8, 400.0}}) {
    const VehicleConfig vehicle = car(filter);
    for (const auto& verdict : compare(drive(vehicle, vehicle), {}, vehicle)) {
      std::printf(
          "order %d, %g Hz: mean %.4f deg, worst class %.4f at %.1f Hz, gain %.4f, uneven %.1e, %.1f s\n",
          filter.order, filter.cutoff_hz, verdict.mean_rad / kDegree, verdict.worst_rad / kDegree,
          verdict.worst_hz, verdict.gain, verdict.uneven, verdict.seconds);
      EXPECT_EQ(verdict.cause, Cause::kNone);
      EXPECT_LT(std::abs(verdict.worst_rad), 0.02 * kDegree);
      EXPECT_LT(std::abs(verdict.mean_rad), 0.02 * kDegree);
      EXPECT_NEAR(verdict.gain, 0.9, 1e-3);
      EXPECT_GT(verdict.seconds, 50.0);
      EXPECT_EQ(explain(verdict, filter), "");
    }
  }
}

TEST(LoopBackComparison, NamesWrongWires) {
  constexpr std::size_t kSine = kAccelerations, kCosine = kSine + 1, kOther = kSine + 2;
  const auto negate = [](std::int32_t& count) { count = -count; };
  const std::vector<std::pair<Cause, std::function<void(Row&)>>> wrong{
      {Cause::kSineInverted, [&](Row& r) { negate(r[kSine]); }},
      {Cause::kCosineInverted, [&](Row& r) { negate(r[kCosine]); }},
      {Cause::kBothInverted, [&](Row& r) { negate(r[kSine]), negate(r[kCosine]); }},
      {Cause::kSwapped, [](Row& r) { std::swap(r[kSine], r[kCosine]); }},
      {Cause::kSwappedInverted, [&](Row& r) { std::swap(r[kSine], r[kCosine]), negate(r[kSine]); }},
      {Cause::kSwappedInverted,
       [&](Row& r) { std::swap(r[kSine], r[kCosine]), negate(r[kSine]), negate(r[kCosine]); }},
      {Cause::kSilent, [](Row& r) { r[kSine] = r[kCosine] = 17; }},
      {Cause::kOneSilent, [](Row& r) { r[kCosine] = 17; }},
      {Cause::kUneven, [](Row& r) { r[kSine] = static_cast<std::int32_t>(0.97 * r[kSine]); }},
      {Cause::kForeign, [](Row& r) { r[kSine] = r[2], r[kCosine] = r[5] * 3 + 1'000'000; }},
      {Cause::kForeign, [](Row& r) { r[kSine] = std::min(r[kSine], 3'000'000); }},
      {Cause::kNone, [](Row& r) { r[0] = -r[0], r[kOther] = 0; }},
  };
  for (const auto& [cause, wires] : wrong) {
    const auto verdicts = compare(right_drive(), wires);
    EXPECT_EQ(verdicts[0].cause, cause) << explain(verdicts[0], {});
    EXPECT_EQ(explain(verdicts[0], {}).empty(), cause == Cause::kNone);
    EXPECT_TRUE(cause == Cause::kNone || verdicts[1].cause == Cause::kNone) << explain(verdicts[1], {});
  }
  const auto swapped = compare(right_drive(), [](Row& r) {
    std::swap_ranges(r.begin() + kSine, r.begin() + kOther, r.begin() + kOther);
  });
  EXPECT_EQ(swapped[0].cause, Cause::kLinesSwapped);
  EXPECT_EQ(swapped[1].cause, Cause::kLinesSwapped);
}

TEST(LoopBackComparison, TellsAWrongFilterFromAWrongDatum) {
  const auto filter = compare(drive(car({6, 180.0}), car()))[0];
  EXPECT_EQ(filter.cause, Cause::kFilter);
  // At rest: 3.8637 / (2 pi) of the difference of the corners' inverses; 1 % more at 20 Hz.
  const double at_rest_s = 3.8637 / (2.0 * std::numbers::pi) * (1.0 / 180.0 - 1.0 / 200.0);
  EXPECT_NEAR(filter.delay_s, at_rest_s, 0.01 * at_rest_s);
  const std::string text = explain(filter, {6, 200.0}), words = "of this order that is one of ";
  ASSERT_NE(text.find(words), std::string::npos) << text;
  EXPECT_NEAR(std::stod(text.substr(text.find(words) + words.size())), 180.0, 0.2);

  // Behind the filter by mistake: the loop is 53 degrees early at 18 Hz.
  VehicleConfig described = car({8, 100.0});
  const auto none = compare(drive(car({8, 990.0}), described), {}, described)[0];
  EXPECT_EQ(none.cause, Cause::kFilter);
  EXPECT_NE(explain(none, described.filter).find("early"), std::string::npos)
      << explain(none, described.filter);

  const auto datum = compare(drive(car(), car({6, 200.0}, 27.0)), {}, car({6, 200.0}, 27.0))[0];
  EXPECT_EQ(datum.cause, Cause::kDatum);
  EXPECT_NEAR(datum.worst_rad, 3.0 * kDegree, 0.02 * kDegree);

  // At one speed the two cannot be separated.
  const std::string steady =
      "[drive]\nwander_km_h = 0.1\n[[drive.plateau]]\nspeed_km_h = 120\nseconds = 60\n[road]\nclass = "
      "\"A\"\n";
  const auto either = compare(drive(car({6, 180.0}), car(), steady))[0];
  EXPECT_EQ(either.cause, Cause::kAngle);
  EXPECT_NE(explain(either, {6, 200.0}).find("two speeds"), std::string::npos);
}

TEST(LoopBackComparison, SaysNothingOfAShortDrive) {
  std::vector<SealedBlock> blocks(right_drive().begin(), right_drive().begin() + 300);
  EXPECT_EQ(compare(blocks)[0].cause, Cause::kTooShort);
}

}  // namespace
}  // namespace roadbalance
