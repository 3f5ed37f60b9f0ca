#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "common/types/blocks.hpp"

namespace roadbalance {

/// Blocks to and from LCM encoding.  None of these allocates but decode_meta.

/// Encodes a block and its CRC once and for all.
void seal(const ScanBlock& block, SealedBlock& out);
void seal(const EdgeBlock& block, SealedBlock& out);
void seal(const SignalBlock& block, SealedBlock& out);
void seal(const GapBlock& block, SealedBlock& out);
void seal(const MetaBlock& block, SealedBlock& out);
void seal(const EndBlock& block, SealedBlock& out);

enum class Refusal : std::uint8_t { kNone, kUnknownType, kWrongSize, kWrongCrc, kOutOfBounds };

/// Takes bytes from outside.  Fills `out` only if type, exact size, CRC and the bounds of every field are
/// good; the kind comes from the type's fingerprint.
/// @param crc_is_good  the caller has found them to end with their CRC, which is not computed again then
Refusal accept(std::span<const std::uint8_t> bytes, SealedBlock& out, bool crc_is_good = false);

/// These decode an accepted or sealed block.  `block.kind` must be the one named.
ScanBlock decode_scan(const SealedBlock& block);
EdgeBlock decode_edge(const SealedBlock& block);
SignalBlock decode_signal(const SealedBlock& block);
GapBlock decode_gap(const SealedBlock& block);
MetaBlock decode_meta(const SealedBlock& block);
EndBlock decode_end(const SealedBlock& block);

/// The values of a scan block that hold for all its scans.
struct ScanSummary {
  std::int64_t period_ps;
  std::int32_t overload, quality;
};
ScanSummary summary_of(const SealedBlock& scan_block);

/// The counts of a scan block as they travel: big endian, [scan][channel], header.scans rows of them.
std::span<const std::uint8_t> encoded_counts(const SealedBlock& scan_block);

}  // namespace roadbalance
