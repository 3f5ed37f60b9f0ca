#include "firmware/board/packet.hpp"

#include "common/types/crc32c.hpp"
#include "firmware/board/byte_order.hpp"

namespace roadbalance::board {
namespace {

struct Framed {
  PacketHeader header;
  std::uint32_t magic = 0;
  std::size_t header_bytes = 0;
};

Framed read_header(std::span<const std::uint8_t> bytes) {
  ByteReader in(bytes);
  Framed framed;
  PacketHeader& header = framed.header;
  framed.magic = in.take<std::uint32_t>();
  header.major = in.take<std::uint8_t>();
  header.minor = in.take<std::uint8_t>();
  framed.header_bytes = in.take<std::uint16_t>();
  header.token = in.take<std::uint32_t>();
  header.sequence = in.take<std::uint32_t>();
  header.first_scan = in.take<std::uint64_t>();
  header.base_ticks = in.take<std::uint64_t>();
  header.ticks_per_scan = in.take<std::uint32_t>();
  header.scans = in.take<std::uint16_t>();
  header.edges = in.take<std::uint16_t>();
  header.flags = in.take<std::uint32_t>();
  header.scans_lost = in.take<std::uint32_t>();
  header.scans_missed = in.take<std::uint32_t>();
  header.edges_lost = in.take<std::uint32_t>();
  header.overloads = in.take<std::uint32_t>();
  header.glitches = in.take<std::uint32_t>();
  return framed;
}

PacketEdge read_edge(std::span<const std::uint8_t> bytes) {
  ByteReader in(bytes);
  PacketEdge edge;
  edge.offset_ticks = in.take<std::int32_t>();
  edge.line = in.take<std::uint8_t>();
  edge.kind = static_cast<PacketEdgeKind>(in.take<std::uint8_t>());
  edge.lost = in.take<std::uint16_t>();
  return edge;
}

bool edges_are_possible(const PacketView& packet) {
  std::int32_t before = INT32_MIN;
  for (std::size_t k = 0; k < packet.header().edges; ++k) {
    const PacketEdge edge = packet.edge(k);
    if (edge.line >= kLines || edge.kind > PacketEdgeKind::kLost || edge.offset_ticks < before) return false;
    before = edge.offset_ticks;
  }
  return true;
}

bool crc_is_right(std::span<const std::uint8_t> bytes) {
  const auto covered = bytes.first(bytes.size() - kCrcBytes);
  return ByteReader(bytes.last(kCrcBytes)).take<std::uint32_t>() == crc32c(covered);
}

PacketFault fault_of(std::span<const std::uint8_t> bytes, const Framed& framed) {
  if (framed.magic != kPacketMagic) return PacketFault::kMagic;
  if (framed.header.major != kProtocolMajor) return PacketFault::kVersion;
  const std::size_t expected =
      framed.header_bytes + framed.header.scans * kScanBytes + framed.header.edges * kEdgeBytes + kCrcBytes;
  if (framed.header_bytes < kHeaderBytes || bytes.size() != expected) return PacketFault::kLength;
  return crc_is_right(bytes) ? PacketFault::kNone : PacketFault::kCrc;
}

}  // namespace

PacketScan PacketView::scan(std::size_t k) const {
  ByteReader in(scans_.subspan(k * kScanBytes, kScanBytes));
  PacketScan scan;
  scan.overload = in.take<std::uint16_t>();
  for (std::int32_t& counts : scan.counts)
    counts = static_cast<std::int32_t>(static_cast<std::uint32_t>(in.take_low(3)) << 8) >> 8;
  return scan;
}

PacketEdge PacketView::edge(std::size_t k) const {
  return read_edge(edges_.subspan(k * kEdgeBytes, kEdgeBytes));
}

std::optional<PacketView> decode_packet(std::span<const std::uint8_t> bytes, PacketFault* fault) {
  PacketFault ignored;
  PacketFault& found = fault != nullptr ? *fault : ignored;
  found = PacketFault::kLength;
  if (bytes.size() < packet_bytes(0, 0) || bytes.size() > kMaxPacketBytes) return std::nullopt;

  const Framed framed = read_header(bytes);
  found = fault_of(bytes, framed);
  if (found != PacketFault::kNone) return std::nullopt;

  PacketView packet;
  packet.header_ = framed.header;
  packet.scans_ = bytes.subspan(framed.header_bytes, framed.header.scans * kScanBytes);
  packet.edges_ = bytes.subspan(framed.header_bytes + packet.scans_.size(), framed.header.edges * kEdgeBytes);
  if (edges_are_possible(packet)) return packet;
  found = PacketFault::kContent;
  return std::nullopt;
}

void encode_header(const PacketHeader& header, std::span<std::uint8_t, kHeaderBytes> bytes) {
  ByteWriter out(bytes);
  out.put(kPacketMagic);
  out.put(header.major);
  out.put(header.minor);
  out.put(static_cast<std::uint16_t>(kHeaderBytes));
  out.put(header.token);
  out.put(header.sequence);
  out.put(header.first_scan);
  out.put(header.base_ticks);
  out.put(header.ticks_per_scan);
  out.put(header.scans);
  out.put(header.edges);
  out.put(header.flags);
  out.put(header.scans_lost);
  out.put(header.scans_missed);
  out.put(header.edges_lost);
  out.put(header.overloads);
  out.put(header.glitches);
}

void encode_scan(const PacketScan& scan, std::span<std::uint8_t, kScanBytes> bytes) {
  ByteWriter out(bytes);
  out.put(scan.overload);
  for (const std::int32_t counts : scan.counts) out.put_low(static_cast<std::uint32_t>(counts), 3);
}

void encode_edge(const PacketEdge& edge, std::span<std::uint8_t, kEdgeBytes> bytes) {
  ByteWriter out(bytes);
  out.put(edge.offset_ticks);
  out.put(edge.line);
  out.put(static_cast<std::uint8_t>(edge.kind));
  out.put(edge.lost);
}

void seal_packet(std::span<std::uint8_t> packet) {
  const auto covered = packet.first(packet.size() - kCrcBytes);
  ByteWriter(packet.last(kCrcBytes)).put(crc32c(covered));
}

}  // namespace roadbalance::board
