#include "firmware/board/packet.hpp"

#include <algorithm>

#include "firmware/board/byte_order.hpp"
#include "firmware/board/test/check.hpp"

namespace roadbalance::board::test {
namespace {

constexpr std::size_t kScans = 2;
constexpr std::size_t kEdges = 3;
using Bytes = std::array<std::uint8_t, packet_bytes(kScans, kEdges)>;

constexpr std::array<PacketEdge, kEdges> kSomeEdges = {{{-7, 0, PacketEdgeKind::kToothForward, 0},
                                                        {-7, 1, PacketEdgeKind::kLost, 65535},
                                                        {2'000'000'000, 1, PacketEdgeKind::kZeroMark, 0}}};

PacketHeader some_header() {
  PacketHeader header;
  header.token = 0x11223344;
  header.sequence = 5;
  header.first_scan = 0x0102030405060708;
  header.base_ticks = 0xFFFFFFFFFFFFFFF0;
  header.ticks_per_scan = 10'000;
  header.scans = kScans;
  header.edges = kEdges;
  header.flags = kOverload;
  header.scans_lost = 1;
  header.scans_missed = 2;
  header.edges_lost = 3;
  header.overloads = 4;
  header.glitches = 6;
  return header;
}

PacketScan extreme_scan() {
  PacketScan scan;
  scan.overload = 0x8001;
  scan.counts = {-8'388'608, 8'388'607, -1,     0,       1,      -2,      127, -128,
                 128,        -129,      32'767, -32'768, 65'535, -65'536, 8,   9};
  return scan;
}

Bytes some_packet() {
  Bytes bytes{};
  const std::span<std::uint8_t> all(bytes);
  encode_header(some_header(), all.first<kHeaderBytes>());
  encode_scan(extreme_scan(), all.subspan(kHeaderBytes).first<kScanBytes>());
  encode_scan(PacketScan{}, all.subspan(kHeaderBytes + kScanBytes).first<kScanBytes>());
  for (std::size_t k = 0; k < kEdges; ++k)
    encode_edge(kSomeEdges[k],
                all.subspan(kHeaderBytes + kScans * kScanBytes + k * kEdgeBytes).first<kEdgeBytes>());
  seal_packet(bytes);
  return bytes;
}

PacketFault fault_of(std::span<const std::uint8_t> bytes) {
  PacketFault fault = PacketFault::kNone;
  const bool refused = !decode_packet(bytes, &fault).has_value();
  CHECK_EQUAL(refused, fault != PacketFault::kNone);
  return fault;
}

// The fault of the packet with one byte changed and the CRC made anew.
PacketFault fault_with(std::size_t at, std::uint8_t value) {
  Bytes bytes = some_packet();
  bytes[at] = value;
  seal_packet(bytes);
  return fault_of(bytes);
}

}  // namespace

BOARD_TEST(packet_keeps_every_field_and_the_extremes_of_24_bits) {
  const Bytes bytes = some_packet();
  const auto packet = decode_packet(bytes);
  REQUIRE(packet.has_value());
  const PacketHeader& header = packet->header();
  CHECK_EQUAL(header.token, 0x11223344);
  CHECK_EQUAL(header.sequence, 5);
  CHECK_EQUAL(header.first_scan, 0x0102030405060708);
  CHECK(header.base_ticks == 0xFFFFFFFFFFFFFFF0);
  CHECK_EQUAL(header.ticks_per_scan, 10'000);
  CHECK_EQUAL(header.flags, kOverload);
  CHECK_EQUAL(header.scans_lost, 1);
  CHECK_EQUAL(header.scans_missed, 2);
  CHECK_EQUAL(header.edges_lost, 3);
  CHECK_EQUAL(header.overloads, 4);
  CHECK_EQUAL(header.glitches, 6);
  REQUIRE(header.scans == kScans && header.edges == kEdges);
  CHECK_EQUAL(packet->scan(0).overload, 0x8001);
  for (std::size_t k = 0; k < kStreamChannels; ++k)
    CHECK_EQUAL(packet->scan(0).counts[k], extreme_scan().counts[k]);
  for (std::size_t k = 0; k < kEdges; ++k) {
    CHECK_EQUAL(packet->edge(k).offset_ticks, kSomeEdges[k].offset_ticks);
    CHECK_EQUAL(packet->edge(k).line, kSomeEdges[k].line);
    CHECK_EQUAL(packet->edge(k).kind, kSomeEdges[k].kind);
    CHECK_EQUAL(packet->edge(k).lost, kSomeEdges[k].lost);
  }
}

// The offsets of PROTOCOL.md, written out.
BOARD_TEST(packet_is_laid_out_as_documented) {
  const Bytes bytes = some_packet();
  const auto number = [&](std::size_t at, std::size_t width) {
    return ByteReader(std::span<const std::uint8_t>(bytes).subspan(at)).take_low(width);
  };
  CHECK(bytes[0] == 'R' && bytes[1] == 'B' && bytes[2] == 'S' && bytes[3] == 'P');
  CHECK_EQUAL(bytes[4], kProtocolMajor);
  CHECK_EQUAL(bytes[5], kProtocolMinor);
  CHECK_EQUAL(number(6, 2), 64);
  CHECK_EQUAL(number(8, 4), 0x11223344);
  CHECK_EQUAL(number(12, 4), 5);
  CHECK_EQUAL(bytes[16], 8);
  CHECK_EQUAL(bytes[23], 1);
  CHECK_EQUAL(bytes[24], 0xF0);
  CHECK_EQUAL(number(32, 4), 10'000);
  CHECK_EQUAL(number(36, 2), kScans);
  CHECK_EQUAL(number(38, 2), kEdges);
  CHECK_EQUAL(number(40, 4), 4);
  CHECK_EQUAL(number(60, 4), 6);
  CHECK_EQUAL(number(64, 2), 0x8001);
  CHECK_EQUAL(number(66, 3), 0x800000);
  CHECK_EQUAL(number(69, 3), 0x7FFFFF);
  CHECK_EQUAL(number(64 + 2 * 50, 4), 0xFFFFFFF9);
}

// RFC 3720, B.4: the CRC of 32 zeros is aa 36 91 8a, in the order it is sent.
BOARD_TEST(packet_has_the_crc_of_rfc_3720) {
  std::array<std::uint8_t, 36> bytes{};
  seal_packet(bytes);
  CHECK(bytes[32] == 0xAA && bytes[33] == 0x36 && bytes[34] == 0x91 && bytes[35] == 0x8A);
}

BOARD_TEST(packet_of_any_other_length_is_refused) {
  std::array<std::uint8_t, sizeof(Bytes) + 8> bytes{};
  const Bytes good = some_packet();
  std::copy(good.begin(), good.end(), bytes.begin());
  for (std::size_t size = 0; size <= bytes.size(); ++size)
    CHECK_EQUAL(fault_of(std::span(bytes).first(size)),
                size == good.size() ? PacketFault::kNone : PacketFault::kLength);
  static std::array<std::uint8_t, kMaxPacketBytes + 1> too_long;
  CHECK_EQUAL(fault_of(too_long), PacketFault::kLength);
}

BOARD_TEST(packet_with_any_bit_flipped_is_refused) {
  Bytes bytes = some_packet();
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
    CHECK(fault_of(bytes) != PacketFault::kNone);
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
  }
  CHECK_EQUAL(fault_of(bytes), PacketFault::kNone);
}

BOARD_TEST(packet_faults_are_named) {
  constexpr std::size_t kFirstEdge = kHeaderBytes + kScans * kScanBytes;
  CHECK_EQUAL(fault_with(0, 'r'), PacketFault::kMagic);
  CHECK_EQUAL(fault_with(4, kProtocolMajor + 1), PacketFault::kVersion);
  CHECK_EQUAL(fault_with(6, 63), PacketFault::kLength);
  CHECK_EQUAL(fault_with(36, kScans + 1), PacketFault::kLength);
  CHECK_EQUAL(fault_with(38, kEdges - 1), PacketFault::kLength);
  CHECK_EQUAL(fault_with(kFirstEdge + 4, kLines), PacketFault::kContent);
  CHECK_EQUAL(fault_with(kFirstEdge + 5, 4), PacketFault::kContent);
  CHECK_EQUAL(fault_with(kFirstEdge + 3, 0x7F), PacketFault::kContent);  // later than the next edge
  Bytes bytes = some_packet();
  bytes.back() ^= 1;
  CHECK_EQUAL(fault_of(bytes), PacketFault::kCrc);
}

BOARD_TEST(packet_of_a_newer_minor_version_is_read_behind_its_longer_header) {
  constexpr std::size_t kMore = 12;
  std::array<std::uint8_t, sizeof(Bytes) + kMore> bytes{};
  const Bytes old = some_packet();
  std::copy(old.begin(), old.begin() + kHeaderBytes, bytes.begin());
  std::copy(old.begin() + kHeaderBytes, old.end(), bytes.begin() + kHeaderBytes + kMore);
  bytes[5] = kProtocolMinor + 1;
  bytes[6] = kHeaderBytes + kMore;
  seal_packet(bytes);
  const auto packet = decode_packet(bytes);
  REQUIRE(packet.has_value());
  CHECK_EQUAL(packet->header().minor, kProtocolMinor + 1);
  CHECK_EQUAL(packet->scan(0).counts[0], -8'388'608);
  CHECK_EQUAL(packet->edge(2).offset_ticks, 2'000'000'000);
}

}  // namespace roadbalance::board::test
