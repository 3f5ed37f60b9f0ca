#pragma once

#include <gtest/gtest.h>

#include <cstdint>

#include "common/bus/codec.hpp"
#include "common/link/ring.hpp"

namespace roadbalance::test {

inline constexpr std::int32_t kNode = 3;
inline constexpr std::int64_t kEpoch = 77;

/// Seals the ring's next block: two that describe the epoch, then scans that carry their number and, every
/// seventh, edges.
inline void seal_next(Ring& ring) {
  SealedBlock* room = ring.claim();
  ASSERT_NE(room, nullptr);
  const std::int64_t sequence = ring.next();
  const BlockHeader header{.node = kNode, .epoch = kEpoch, .sequence = sequence, .time_ns = sequence * 1000};
  if (sequence <= 2) {
    seal(
        MetaBlock{
            .header = header, .part = static_cast<std::int32_t>(sequence - 1), .parts = 2, .text = "car"},
        *room);
  } else if (sequence % 7 == 0) {
    EdgeBlock edges;
    edges.header = header;
    seal(edges, *room);
  } else {
    ScanBlock scans;
    scans.header = header;
    scans.header.scans = 20;
    scans.period_ps = 500'000'000;
    scans.counts[3][5] = static_cast<std::int32_t>(sequence);
    seal(scans, *room);
  }
  ring.commit();
}

}  // namespace roadbalance::test
