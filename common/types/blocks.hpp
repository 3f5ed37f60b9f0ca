#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/types/block.hpp"
#include "common/types/edge_code.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {

/// The contents of a SealedBlock, one struct per kind; fields as in common/wire.

inline constexpr int kScansPerBlock = 20;
inline constexpr int kEdgeBytesPerBlock = 1200;
inline constexpr int kSamplesPerBlock = 64;
inline constexpr int kMetaBytesPerBlock = 1200;

struct ScanBlock {
  BlockHeader header;
  std::int64_t period_ps = 0;
  std::array<std::array<std::int32_t, kChannels>, kScansPerBlock> counts{};  ///< [scan][channel]
  std::int32_t overload = 0;
  std::int32_t quality = 0;

  /// Node time of row `row`, ns.
  std::int64_t row_time_ns(std::int64_t row) const { return header.time_ns + row * period_ps / 1000; }
};

/// Edges of both lines in order of time; `codes` as on the wire, see edge_code.hpp.
struct EdgeBlock {
  BlockHeader header;
  std::int32_t edges = 0;
  std::int32_t size = 0;  ///< bytes of `codes` that count
  std::array<std::uint8_t, kEdgeBytesPerBlock> codes{};

  /// Adds an edge at or after the last one.  False if the block is full or the edge too far away (2^30 ns):
  /// then a new block begins.  The first edge sets header.time_ns.
  bool add(const Edge& edge);
  bool empty() const { return edges == 0; }
  /// The codes are those of so many edges in order of time.
  bool is_sound() const;
  /// The edges as they were added.
  std::vector<Edge> unpack() const;

 private:
  EdgeReader reader() const {
    return {header.time_ns, std::span(codes).first(static_cast<std::size_t>(size))};
  }
  ExpectedEdges expected_;
  std::int64_t last_ns_ = 0;
};

/// Samples of the node's signals as they came.
struct SignalBlock {
  BlockHeader header;
  std::int32_t samples = 0;
  std::array<std::int64_t, kSamplesPerBlock> time_ns{};
  std::array<double, kSamplesPerBlock> value{};
  std::array<std::int16_t, kSamplesPerBlock> signal{};

  /// False if the block is full: then a new one begins.  The first sample sets header.time_ns.
  /// A block with a value that is no number would be refused by every receiver: none is given.
  bool add(const SignalSample& sample);
  bool empty() const { return samples == 0; }
  /// The samples as they were added.
  std::vector<SignalSample> unpack() const;
};

struct GapBlock {
  BlockHeader header;
  GapCause cause = GapCause::kRingFull;
};

struct MetaBlock {
  BlockHeader header;
  MetaKind kind = MetaKind::kVehicleToml;
  std::int32_t part = 0;
  std::int32_t parts = 1;
  std::string text;  ///< at most kMetaBytesPerBlock
};

/// `text` in parts that fit, in order; an empty text has one empty part.  Headers are left to the caller.
std::vector<MetaBlock> split_text(MetaKind kind, const std::string& text);

struct EndBlock {
  BlockHeader header;
  std::int64_t blocks = 0;
  std::int64_t scans_sealed = 0;
  std::int64_t scans_missing = 0;
  std::uint32_t blocks_crc32c = 0;  ///< see BlockSum
};

/// The sum that an epoch's end carries of the blocks before it: CRC-32C over the CRC that each one ends with,
/// in sequence.  A block that is another, or in another place, shows by it, whatever its own CRC is.
class BlockSum {
 public:
  BlockSum() = default;
  explicit BlockSum(std::uint32_t crc32c) : crc32c_(crc32c) {}

  /// The next block of the epoch; never the end.
  void add(const SealedBlock& block);
  /// The same by the CRC that it ends with.
  void add(std::uint32_t block_crc32c);
  std::uint32_t crc32c() const { return crc32c_; }

 private:
  std::uint32_t crc32c_ = 0;
};

}  // namespace roadbalance
