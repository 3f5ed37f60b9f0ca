#pragma once

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "common/bus/wire_format.hpp"
#include "common/types/blocks.hpp"

/// scan_block_t on the wire.  Scan blocks are the bulk of the bus, and LCM's own code, byte by byte, takes as
/// long as all else that a node or a recorder does with one.  For use inside common/bus only.
namespace roadbalance::wire_format {

struct ScanFields {
  std::int32_t node;
  std::int64_t epoch, sequence, first_scan, scans, time_ns, period_ps;
  std::int32_t overload, quality;
};
inline constexpr std::size_t kScanCountsAt =
    60;  ///< behind fingerprint and the fields from node to period_ps
inline constexpr std::size_t kScanCounts = std::size_t{kScansPerBlock} * kChannels;
inline constexpr std::size_t kScanBytes = kScanCountsAt + 4 * kScanCounts + 12;

inline std::int32_t load_i32(const std::uint8_t* bytes) {
  return static_cast<std::int32_t>(load_u32(bytes));
}

inline void store_i32(std::int32_t value, std::uint8_t* bytes) {
  store_u32(static_cast<std::uint32_t>(value), bytes);
}

inline void store_i64(std::int64_t value, std::uint8_t* bytes) {
  const auto bits = static_cast<std::uint64_t>(value);
  store_u32(static_cast<std::uint32_t>(bits >> 32), bytes);
  store_u32(static_cast<std::uint32_t>(bits), bytes + 4);
}

inline ScanFields read_scan_fields(std::span<const std::uint8_t> bytes) {
  assert(bytes.size() == kScanBytes);
  const auto i64 = [&bytes](std::size_t field) { return load_i64(bytes.data() + 12 + 8 * field); };
  const std::uint8_t* behind_counts = bytes.data() + kScanCountsAt + 4 * kScanCounts;
  return {.node = load_i32(bytes.data() + 8),
          .epoch = i64(0),
          .sequence = i64(1),
          .first_scan = i64(2),
          .scans = i64(3),
          .time_ns = i64(4),
          .period_ps = i64(5),
          .overload = load_i32(behind_counts),
          .quality = load_i32(behind_counts + 4)};
}

/// Converts two counts side by side in memory, each big endian, to or from those of this processor.
inline std::uint64_t swap_pair(std::uint64_t pair) {
  if constexpr (std::endian::native == std::endian::big) return pair;
  return std::rotl(__builtin_bswap64(pair), 32);
}

/// Counts to or from the wire, two at a time: they are nearly all of a block.
inline void swap_counts(const void* from, void* to) {
  static_assert(kScanCounts % 2 == 0);
  for (std::size_t at = 0; at < 4 * kScanCounts; at += 8) {
    std::uint64_t pair;
    std::memcpy(&pair, static_cast<const std::uint8_t*>(from) + at, sizeof pair);
    pair = swap_pair(pair);
    std::memcpy(static_cast<std::uint8_t*>(to) + at, &pair, sizeof pair);
  }
}

inline void read_scan_counts(std::span<const std::uint8_t> bytes, ScanBlock& out) {
  assert(bytes.size() == kScanBytes);
  static_assert(sizeof out.counts == 4 * kScanCounts);
  swap_counts(bytes.data() + kScanCountsAt, out.counts.data());
}

/// All but the CRC.
inline void write_scan(const ScanBlock& block, std::int64_t fingerprint, std::span<std::uint8_t> bytes) {
  assert(bytes.size() == kScanBytes);
  const BlockHeader& header = block.header;
  store_i64(fingerprint, bytes.data());
  store_i32(header.node, bytes.data() + 8);
  std::uint8_t* at = bytes.data() + 12;
  for (const std::int64_t field :
       {header.epoch, header.sequence, header.first_scan, header.scans, header.time_ns, block.period_ps}) {
    store_i64(field, at);
    at += 8;
  }
  swap_counts(block.counts.data(), at);
  at += sizeof block.counts;
  store_i32(block.overload, at);
  store_i32(block.quality, at + 4);
}

}  // namespace roadbalance::wire_format
