#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <utility>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/types/crc32c.hpp"
#include "firmware/epoch_packer.hpp"
#include "firmware/test/scripted_front_end.hpp"
#include "firmware/test/vehicle.hpp"
#include "sim/pulse_train.hpp"

namespace roadbalance::test {

inline constexpr double kRate_hz = 2000.0;
inline constexpr std::int64_t kEpoch = 77;

/// Edges of both wheels.
inline std::vector<Edge> turning(double seconds, double from_s = 0.0, double hz = 18.0) {
  std::vector<Edge> all;
  for (std::uint8_t line = 0; line < 2; ++line) {
    const sim::PulseTrain train{.angle_rad = [=](double t) { return 2 * std::numbers::pi * hz * t; },
                                .line = line};
    const auto edges = train.edges(from_s, seconds);
    all.insert(all.end(), edges.begin(), edges.end());
  }
  std::stable_sort(all.begin(), all.end(), [](const Edge& a, const Edge& b) { return a.time < b.time; });
  return all;
}

/// An epoch of marked scans, sealed at once.
inline std::vector<SealedBlock> blocks_of(std::vector<Scan> scans, std::vector<Edge> edges,
                                          std::size_t run = 64) {
  const auto vehicle = one_node_vehicle(kRate_hz);
  ScriptedFrontEnd device(std::move(scans), std::move(edges), run);
  std::vector<SealedBlock> blocks;
  pack_epoch(device, vehicle, vehicle.node[0], kEpoch, [&](const SealedBlock& b) { blocks.push_back(b); });
  return blocks;
}

/// Conditions on every epoch: sequence, tiling, every scan where it belongs, totals of the end.
inline void check_epoch(const std::vector<SealedBlock>& blocks, std::int64_t scans) {
  ASSERT_FALSE(blocks.empty());
  std::int64_t sequence = 1, next = 0, sealed = 0, missing = 0;
  std::vector<std::uint8_t> crcs;  // as the blocks end with them
  for (const auto& block : blocks) {
    SealedBlock copy;
    ASSERT_EQ(accept(block.bytes(), copy), Refusal::kNone) << "sequence " << block.header.sequence;
    EXPECT_EQ(block.header.sequence, sequence++);
    EXPECT_EQ(block.header.epoch, kEpoch);
    if (block.kind != BlockKind::kEnd) crcs.insert(crcs.end(), block.bytes().end() - 4, block.bytes().end());
    if (block.kind == BlockKind::kScan || block.kind == BlockKind::kGap) {
      EXPECT_EQ(block.header.first_scan, next);
      next += block.header.scans;
    }
    if (block.kind == BlockKind::kGap) missing += block.header.scans;
    if (block.kind != BlockKind::kScan) continue;
    sealed += block.header.scans;
    const ScanBlock scan = decode_scan(block);
    for (std::int64_t i = 0; i < scan.header.scans; ++i)
      for (std::size_t c = 0; c < kAccelerations; ++c)
        ASSERT_EQ(scan.counts[static_cast<std::size_t>(i)][c], marked_counts(scan.header.first_scan + i, c));
  }
  EXPECT_EQ(next, scans);
  ASSERT_EQ(blocks.back().kind, BlockKind::kEnd);
  const EndBlock end = decode_end(blocks.back());
  EXPECT_EQ(end.header.first_scan, scans);
  EXPECT_EQ(end.blocks, static_cast<std::int64_t>(blocks.size()));
  EXPECT_EQ(end.scans_sealed, sealed);
  EXPECT_EQ(end.scans_missing, missing);
  EXPECT_EQ(end.blocks_crc32c, crc32c_by_table(crcs));
}

}  // namespace roadbalance::test
