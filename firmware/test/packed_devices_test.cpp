#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "firmware/block_packer.hpp"
#include "firmware/test/sealed_epoch.hpp"
#include "firmware/test/valve.hpp"

// Blocks of devices that give more than scans and edges, or are away for a while.
namespace roadbalance {
namespace {

using test::blocks_of;
using test::check_epoch;
using test::kEpoch;
using test::kRate_hz;
using test::turning;

std::int64_t time_at(double seconds) {
  return std::llround(seconds * 1e9);
}

/// Two signals at 100 Hz, of different devices: in order of time each.
std::vector<SignalSample> speeds(double seconds) {
  std::vector<SignalSample> all;
  for (double t = 0.0; t < seconds; t += 0.01)
    for (const std::uint16_t signal : {std::uint16_t{7}, std::uint16_t{255}})
      all.push_back({node_time_from_ns(time_at(t) - 1000 * signal), signal, 20.0 + 0.1 * signal + t});
  return all;
}

std::vector<SignalSample> recorded_signals(const std::vector<SealedBlock>& blocks) {
  std::vector<SignalSample> recorded;
  for (const auto& block : blocks) {
    if (block.kind != BlockKind::kSignal) continue;
    const auto some = decode_signal(block).unpack();
    recorded.insert(recorded.end(), some.begin(), some.end());
  }
  return recorded;
}

bool operator==(const SignalSample& a, const SignalSample& b) {
  return a.time == b.time && a.signal == b.signal && a.value == b.value;
}

TEST(BlockPacker, RecordsEverySignalAsItCameAndSoon) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::ScriptedFrontEnd device(test::marked_scans(0, 3000, kRate_hz), turning(1.5));
  device.signals = speeds(1.5);
  std::vector<SealedBlock> blocks;
  pack_epoch(device, vehicle, vehicle.node[0], kEpoch, [&](const SealedBlock& b) { blocks.push_back(b); });
  check_epoch(blocks, 3000);
  const auto recorded = recorded_signals(blocks);
  ASSERT_EQ(recorded.size(), device.signals.size());
  for (std::size_t i = 0; i < recorded.size(); ++i)
    ASSERT_TRUE(recorded[i] == device.signals[i]) << "sample " << i;
  std::int64_t scans_sealed = 0;
  for (const auto& block : blocks) {
    if (block.kind == BlockKind::kScan) scans_sealed = block.header.first_scan + block.header.scans;
    if (block.kind != BlockKind::kSignal) continue;
    EXPECT_EQ(block.header.first_scan, scans_sealed);
    EXPECT_EQ(block.header.time_ns, decode_signal(block).time_ns[0]);
    // 200 ms and one read of 64 scans, behind which the samples came.
    EXPECT_LE(scans_sealed * 500'000 - block.header.time_ns, 200'000'000 + 64 * 500'000 + 500'000);
  }
}

TEST(BlockPacker, RecordsNoSignalBeforeTheStartNorAfterTheStop) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, nullptr);
  const auto scans = test::marked_scans(0, 600, kRate_hz);
  const auto add = [&](std::size_t first, std::size_t count, double value) {
    packer.add(std::span(scans).subspan(first, count), {}, false);
    const SignalSample sample{scans[first].time, 1, value};
    packer.add({&sample, 1});
  };
  add(0, 100, 1.0);
  packer.start();
  add(100, 100, 2.0);
  packer.stop();
  add(200, 400, 3.0);  // so many that no angle is waited for any more
  ASSERT_TRUE(packer.finish());
  const auto recorded = recorded_signals(valve.blocks);
  ASSERT_EQ(recorded.size(), 1U);
  EXPECT_EQ(recorded[0].value, 2.0);
}

TEST(BlockPacker, DeclaresScansOfADeviceThatWasNotThere) {
  auto scans = test::marked_scans(0, 333, kRate_hz);
  const auto lost = test::marked_scans(400, 1000, kRate_hz), gone = test::marked_scans(1900, 2000, kRate_hz);
  scans.insert(scans.end(), lost.begin(), lost.end());
  scans.insert(scans.end(), gone.begin(), gone.end());
  scans[933].after_absence = true;
  const auto blocks = blocks_of(scans, turning(1.0));
  check_epoch(blocks, 2000);
  std::vector<GapBlock> gaps;
  for (const auto& block : blocks)
    if (block.kind == BlockKind::kGap) gaps.push_back(decode_gap(block));
  ASSERT_EQ(gaps.size(), 2U);
  EXPECT_EQ(gaps[0].cause, GapCause::kDeviceOverrun);
  EXPECT_EQ(gaps[0].header.scans, 67);
  EXPECT_EQ(gaps[1].cause, GapCause::kDeviceGone);
  EXPECT_EQ(gaps[1].header.first_scan, 1000);
  EXPECT_EQ(gaps[1].header.scans, 900);
}

TEST(BlockPacker, DatesAGapOfAnyLengthAndRefusesScansThatNoRecordCanNumber) {
  auto scans = test::marked_scans(0, 60, kRate_hz);
  for (std::size_t i = 20; i < 60; ++i) scans[i].index += kIndexLimit - 40;  // the last 20 are beyond
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, nullptr);
  packer.start();
  packer.add(scans, {}, false);
  packer.device_ended();
  ASSERT_TRUE(packer.finish());
  EXPECT_EQ(packer.counts().scans_refused, 20);
  SealedBlock copy;
  for (const auto& block : valve.blocks) {
    EXPECT_EQ(accept(block.bytes(), copy), Refusal::kNone) << "sequence " << block.header.sequence;
    if (block.kind != BlockKind::kGap) continue;
    EXPECT_EQ(block.header.first_scan, 20);
    EXPECT_EQ(block.header.scans, kIndexLimit - 40);
    EXPECT_EQ(block.header.time_ns, 20 * 500'000);
  }
  EXPECT_EQ(decode_end(valve.blocks.back()).scans_missing, kIndexLimit - 40);
}

TEST(BlockPacker, TakesTheReferencesOfALoopBackAsTheyWereConverted) {
  for (const bool loop_back : {false, true}) {
    auto vehicle = test::one_node_vehicle(kRate_hz);
    vehicle.node[0].wiring.loop_back = loop_back;
    auto scans = test::marked_scans(0, 1000, kRate_hz);
    for (Scan& scan : scans)
      for (int c = 0; c < kReferences; ++c)
        scan.references[static_cast<std::size_t>(c)] = -static_cast<std::int32_t>(4 * scan.index + c) - 1;
    test::ScriptedFrontEnd device(scans, turning(0.5));
    std::int64_t converted = 0, sealed = 0, known = 0;
    pack_epoch(device, vehicle, vehicle.node[0], kEpoch, [&](const SealedBlock& b) {
      if (b.kind != BlockKind::kScan) return;
      const ScanBlock block = decode_scan(b);
      known += (block.quality & (kQualityNoReference0 | kQualityNoReference1)) == 0 ? 1 : 0;
      for (std::int64_t i = 0; i < block.header.scans; ++i, ++sealed) {
        const auto& row = block.counts[static_cast<std::size_t>(i)];
        const auto& mine = scans[static_cast<std::size_t>(block.header.first_scan + i)].references;
        converted += std::equal(mine.begin(), mine.end(), row.begin() + kAccelerations) ? 1 : 0;
      }
    });
    EXPECT_EQ(sealed, 1000);
    EXPECT_EQ(converted, loop_back ? 1000 : 0);
    EXPECT_GT(known, 20) << "edges still say if the angle is known";
  }
}

TEST(BlockPacker, LosesSignalsOfAFullSinkInItsGapOnly) {
  const auto vehicle = test::one_node_vehicle(kRate_hz);
  test::Valve valve;
  BlockPacker packer(vehicle, vehicle.node[0], kEpoch, valve, nullptr);
  const auto samples = speeds(2.0);
  const auto scans = test::marked_scans(0, 4000, kRate_hz);
  packer.start();
  std::size_t sample = 0;
  for (std::size_t i = 0; i < scans.size(); i += 50) {
    valve.open = i < 1000 || i >= 3000;
    packer.add(std::span(scans).subspan(i, 50), {}, false);
    const std::size_t first = sample;
    while (sample < samples.size() && samples[sample].time <= scans[i + 49].time) ++sample;
    packer.add(std::span(samples).subspan(first, sample - first));
  }
  packer.device_ended();
  ASSERT_TRUE(packer.finish());
  check_epoch(valve.blocks, 4000);
  std::int64_t gap_ns = 0, gap_end_ns = 0;
  for (const auto& block : valve.blocks)
    if (block.kind == BlockKind::kGap) {
      EXPECT_EQ(gap_ns, 0) << "one gap";
      EXPECT_EQ(decode_gap(block).cause, GapCause::kRingFull);
      gap_ns = block.header.first_scan * 500'000;
      gap_end_ns = gap_ns + block.header.scans * 500'000;
    }
  ASSERT_GT(gap_ns, 0);
  // A block of 200 ms was waiting when the sink filled up; without edges scans are sealed 100 ms late, and
  // samples come with reads of 25 ms.
  const auto recorded = recorded_signals(valve.blocks);
  std::size_t lost = 0, next = 0;
  for (const SignalSample& given : samples) {
    if (next < recorded.size() && recorded[next] == given) {
      ++next;
      continue;
    }
    ++lost;
    EXPECT_GE(to_ns(given.time), gap_ns - 200'000'000);
    EXPECT_LE(to_ns(given.time), gap_end_ns + 100'000'000 + 2 * 25'000'000);
  }
  EXPECT_EQ(next, recorded.size()) << "recorded is what was given, in its order";
  EXPECT_GT(lost, 100U);
}

}  // namespace
}  // namespace roadbalance
