#pragma once

#include <algorithm>
#include <cstdint>

#include "common/bus/codec.hpp"
#include "common/bus/control_messages.hpp"
#include "hil_tests/fuzz/byte_reader.hpp"

namespace roadbalance::fuzz {

/// A node that sends nothing but the truth: block `sequence` of an epoch is always the same, mostly scans,
/// and scan indices run on.  Block `last` is the end.
///
/// `some_*` are its possible messages to a recorder that has handed on its blocks up to `delivered`, or their
/// fate there; the fuzzer's bytes choose.
struct TrueNode {
  std::int32_t node;
  std::int64_t epoch;
  std::int64_t last;

  /// One description, a block of edges, one of signals, then scans.
  static constexpr std::int64_t kBeside = 3, kPerTurn = kBeside + 6;

  std::int64_t first_scan(std::int64_t sequence) const {
    const std::int64_t before = sequence - 1;
    const std::int64_t in_turn = before % kPerTurn;
    return kScansPerBlock *
           ((kPerTurn - kBeside) * (before / kPerTurn) + std::max<std::int64_t>(0, in_turn - kBeside));
  }

  std::uint32_t sum_before_end() const {
    BlockSum sum;
    for (std::int64_t sequence = 1; sequence < last; ++sequence) sum.add(block(sequence));
    return sum.crc32c();
  }

  SealedBlock block(std::int64_t sequence) const {
    const BlockHeader header{.node = node,
                             .epoch = epoch,
                             .sequence = sequence,
                             .first_scan = first_scan(sequence),
                             .time_ns = 500'000 * first_scan(sequence)};
    SealedBlock sealed;
    if (sequence == last) {
      seal(EndBlock{.header = header,
                    .blocks = last,
                    .scans_sealed = header.first_scan,
                    .blocks_crc32c = sum_before_end()},
           sealed);
    } else if ((sequence - 1) % kPerTurn == 0) {
      seal(MetaBlock{.header = header, .text = "[model]"}, sealed);
    } else if ((sequence - 1) % kPerTurn == 1) {
      EdgeBlock edges;
      edges.header = header;
      seal(edges, sealed);
    } else if ((sequence - 1) % kPerTurn == 2) {
      SignalBlock signals;
      signals.header = header;
      static_cast<void>(signals.add({.signal = 7, .value = static_cast<double>(sequence)}));
      seal(signals, sealed);
    } else {
      ScanBlock scans{.header = header, .period_ps = 500'000'000};
      scans.header.scans = kScansPerBlock;
      scans.counts[0][0] = static_cast<std::int32_t>(sequence);
      seal(scans, sealed);
    }
    return sealed;
  }

  /// One that was delivered, the next one, or one ahead of it.
  SealedBlock some_block(ByteReader& in, std::int64_t delivered) const {
    return block(std::clamp<std::int64_t>(delivered + in.below(64) - 16, 1, last));
  }

  Heartbeat some_heartbeat(ByteReader& in, std::int64_t delivered) const {
    Heartbeat beat{.node = node, .epoch = epoch};
    beat.next = std::min(delivered + 1 + in.below(256), last + 1);
    beat.base = std::clamp<std::int64_t>(delivered + in.below(256) - 200, 1, beat.next);
    beat.state = beat.next > last ? NodeState::kEnded : NodeState::kStarted;
    return beat;
  }

  /// A disk calls durable what was delivered, or less.
  static std::int64_t some_durable(ByteReader& in, std::int64_t delivered) {
    return std::min(delivered, in.below(65536));
  }
};

}  // namespace roadbalance::fuzz
