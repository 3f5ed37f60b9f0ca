#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/board/protocol.hpp"

/// One packet of the bulk stream: header, scans, edges, CRC.  One packet is one USB transfer.
namespace roadbalance::board {

inline constexpr std::uint32_t kPacketMagic = 0x50534252;  ///< "RBSP"
inline constexpr std::size_t kHeaderBytes = 64;
inline constexpr std::size_t kScanBytes = 2 + 3 * kStreamChannels;
inline constexpr std::size_t kEdgeBytes = 8;
inline constexpr std::size_t kCrcBytes = 4;

/// A host's transfer holds this; a packet is always smaller, so that a short USB packet (or an empty one,
/// behind a multiple of 512 bytes) ends each transfer.
inline constexpr std::size_t kTransferBytes = 8192;
inline constexpr std::size_t kMaxPacketBytes = kTransferBytes - 16;

/// A running board sends a packet at least this often, an empty one if it has nothing.
inline constexpr std::uint32_t kSilenceLimitMs = 100;

enum PacketFlag : std::uint32_t {
  kScansLostBefore = 1u << 0,  ///< first_scan is not where the packet before ended
  kEdgesLostHere = 1u << 1,    ///< one of the edges is a kLost
  kOverload = 1u << 2,         ///< one of the scans has an overload
  kPatternOn = 1u << 3,        ///< the channels are the test pattern
  kLocked0 = 1u << 4,          ///< the reference of wheel 0 followed its encoder at the end of this packet
  kLocked1 = 1u << 5,          ///< of wheel 1
};

struct PacketHeader {
  std::uint8_t major = kProtocolMajor;
  std::uint8_t minor = kProtocolMinor;
  std::uint32_t token = 0;           ///< of the run
  std::uint32_t sequence = 0;        ///< from 0 in each run, wraps; a jump is packets lost on the way
  std::uint64_t first_scan = 0;      ///< index of the first scan here, or of the next one if there is none
  std::uint64_t base_ticks = 0;      ///< time of the first scan; without one of the first edge; else now
  std::uint32_t ticks_per_scan = 0;  ///< scan n of this packet was converted at base_ticks + n ticks_per_scan
  std::uint16_t scans = 0;
  std::uint16_t edges = 0;
  std::uint32_t flags = 0;       ///< OR of PacketFlag
  std::uint32_t scans_lost = 0;  ///< the counters of Status, at the end of this packet
  std::uint32_t scans_missed = 0;
  std::uint32_t edges_lost = 0;
  std::uint32_t overloads = 0;
  std::uint32_t glitches = 0;
};

struct PacketScan {
  std::uint16_t overload = 0;                          ///< bit k: channel k at its limit
  std::array<std::int32_t, kStreamChannels> counts{};  ///< -2^23 .. 2^23 - 1
};

enum class PacketEdgeKind : std::uint8_t {
  kToothForward = 0,
  kZeroMark = 1,
  kToothBackward = 2,
  kLost = 3,  ///< edges of this line were lost between the one before and this instant
};

struct PacketEdge {
  std::int32_t offset_ticks = 0;  ///< behind base_ticks; negative: before the first scan here
  std::uint8_t line = 0;
  PacketEdgeKind kind = PacketEdgeKind::kToothForward;
  std::uint16_t lost = 0;  ///< kLost: how many, at most 65535 are reported; else 0
};

enum class PacketFault : std::uint8_t {
  kNone,
  kLength,  ///< shorter than an empty packet, longer than the longest, or not the length in its header
  kMagic,
  kVersion,  ///< another major version
  kCrc,
  kContent,  ///< an edge of a line or kind that there is not
};

/// A packet whose every field has been checked; refers to the bytes.
class PacketView {
 public:
  const PacketHeader& header() const { return header_; }
  PacketScan scan(std::size_t k) const;  ///< k < header().scans
  PacketEdge edge(std::size_t k) const;  ///< k < header().edges

 private:
  friend std::optional<PacketView> decode_packet(std::span<const std::uint8_t>, PacketFault*);
  PacketHeader header_;
  std::span<const std::uint8_t> scans_;
  std::span<const std::uint8_t> edges_;
};

/// @param bytes  one whole transfer
/// @param fault  if given, why there is no packet, else kNone
std::optional<PacketView> decode_packet(std::span<const std::uint8_t> bytes, PacketFault* fault = nullptr);

constexpr std::size_t packet_bytes(std::size_t scans, std::size_t edges) {
  return kHeaderBytes + scans * kScanBytes + edges * kEdgeBytes + kCrcBytes;
}

/// The parts of a packet, each written where it belongs; seal_packet() comes last.
void encode_header(const PacketHeader& header, std::span<std::uint8_t, kHeaderBytes> bytes);
void encode_scan(const PacketScan& scan, std::span<std::uint8_t, kScanBytes> bytes);
void encode_edge(const PacketEdge& edge, std::span<std::uint8_t, kEdgeBytes> bytes);

/// Writes the CRC-32C of all bytes but the last four into those.
void seal_packet(std::span<std::uint8_t> packet);

}  // namespace roadbalance::board
