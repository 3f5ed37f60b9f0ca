#include "firmware/backends/usb/packet_stream.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace roadbalance {
namespace {

using board::PacketHeader;

constexpr std::uint32_t kToken = 77;
constexpr std::uint32_t kPeriod = 1000;
constexpr std::uint32_t kTickHz = 10'000'000;
constexpr std::uint64_t kBegin = 4'990'000;

struct Reported {
  std::uint32_t sequence = 0;
  std::uint64_t first_scan = 0;
  std::uint16_t scans = 10;
  std::uint32_t token = kToken;
  std::uint32_t scans_lost = 0;
  std::uint32_t glitches = 0;
  std::uint64_t ahead = 0;  ///< scans by which it is numbered before its time
};

std::vector<std::uint8_t> packet(const Reported& reported, const std::vector<board::PacketEdge>& edges = {}) {
  std::vector<std::uint8_t> bytes(board::packet_bytes(reported.scans, edges.size()));
  const std::span<std::uint8_t> all(bytes);
  PacketHeader header;
  header.token = reported.token;
  header.sequence = reported.sequence;
  header.first_scan = reported.first_scan + reported.ahead;
  header.base_ticks = 5'000'000 + reported.first_scan * kPeriod;
  header.ticks_per_scan = kPeriod;
  header.scans = reported.scans;
  header.edges = static_cast<std::uint16_t>(edges.size());
  header.scans_lost = reported.scans_lost;
  header.glitches = reported.glitches;
  for (const auto& edge : edges)
    if (edge.kind == board::PacketEdgeKind::kLost) header.flags |= board::kEdgesLostHere;
  board::encode_header(header, all.first<board::kHeaderBytes>());
  std::size_t at = board::kHeaderBytes;
  for (int k = 0; k < reported.scans; ++k, at += board::kScanBytes)
    board::encode_scan({}, all.subspan(at).first<board::kScanBytes>());
  for (const auto& edge : edges) {
    board::encode_edge(edge, all.subspan(at).first<board::kEdgeBytes>());
    at += board::kEdgeBytes;
  }
  board::seal_packet(all);
  return bytes;
}

class PacketStreamTest : public testing::Test {
 protected:
  PacketStreamTest() { stream.start(kToken, kPeriod, kTickHz, kBegin); }

  std::optional<PacketStream::Packet> take(const Reported& reported, std::uint32_t dropped = 0) {
    bytes = packet(reported);
    return stream.take(bytes, dropped);
  }

  DeviceReport report{"usb:test"};
  PacketStream stream{report};
  std::vector<std::uint8_t> bytes;
};

TEST_F(PacketStreamTest, TakesEachPacketOfTheRunOnce) {
  const auto first = take({});
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->after_missing);
  EXPECT_EQ(first->content.header().scans, 10);
  EXPECT_TRUE(take({.sequence = 1, .first_scan = 10}));
  EXPECT_FALSE(take({.sequence = 1, .first_scan = 10})) << "once more";
  EXPECT_EQ(report.of(DeviceCounter::kPacketsRefused), 1);
  EXPECT_EQ(report.of(DeviceCounter::kPacketsMissing), 0);
}

TEST_F(PacketStreamTest, CountsMissingPacketsWithoutThoseTheNodeItselfDropped) {
  ASSERT_TRUE(take({}));
  const auto later = take({.sequence = 6, .first_scan = 60}, 2);
  ASSERT_TRUE(later);
  EXPECT_TRUE(later->after_missing);
  EXPECT_EQ(report.of(DeviceCounter::kPacketsMissing), 3);
}

TEST_F(PacketStreamTest, TellsCutTransfersFromSpoiledOnes) {
  bytes = packet({});
  std::vector<std::uint8_t> part(bytes.begin(), bytes.end() - 7);
  EXPECT_FALSE(stream.take(part, 0));
  part.resize(20);
  EXPECT_FALSE(stream.take(part, 0));
  EXPECT_EQ(report.of(DeviceCounter::kShortPackets), 2);
  EXPECT_EQ(report.of(DeviceCounter::kPacketsRefused), 0);

  auto turned = bytes;
  turned[200] ^= 1;
  EXPECT_FALSE(stream.take(turned, 0));
  auto longer = bytes;
  longer.push_back(0);
  EXPECT_FALSE(stream.take(longer, 0));
  EXPECT_EQ(report.of(DeviceCounter::kPacketsRefused), 2);
  EXPECT_EQ(report.of(DeviceCounter::kShortPackets), 2);
  EXPECT_FALSE(stream.take({}, 0));
  EXPECT_EQ(report.of(DeviceCounter::kShortPackets), 2) << "an empty transfer only ends one";
}

TEST_F(PacketStreamTest, LeavesPacketsOfAnEarlierRunAside) {
  EXPECT_FALSE(take({.token = kToken - 1}));
  EXPECT_EQ(report.of(DeviceCounter::kPacketsRefused), 0);
  EXPECT_TRUE(take({}));
}

TEST_F(PacketStreamTest, RefusesScansThatGoBackOrOfAnotherRate) {
  ASSERT_TRUE(take({}));
  EXPECT_FALSE(take({.sequence = 1, .first_scan = 9}));
  stream.start(kToken, kPeriod + 1, kTickHz, kBegin);
  EXPECT_FALSE(take({}));
  EXPECT_EQ(report.of(DeviceCounter::kPacketsRefused), 2);
}

TEST_F(PacketStreamTest, RefusesScansBeforeTheTimerCanHaveCountedThem) {
  ASSERT_TRUE(take({}));
  EXPECT_FALSE(take({.sequence = 1, .first_scan = 10, .ahead = 10'011})) << "more than a second";
  for (int bit = 14; bit < 64; ++bit)
    EXPECT_FALSE(take({.sequence = 1, .first_scan = 10, .ahead = std::uint64_t{1} << bit})) << bit;
  EXPECT_EQ(report.of(DeviceCounter::kPacketsRefused), 51);
  EXPECT_TRUE(take({.sequence = 1, .first_scan = 10})) << "the true one is still waited for";
  EXPECT_TRUE(take({.sequence = 2, .first_scan = std::uint64_t{1} << 40})) << "a gap as long as its time";
  stream.distrust();
  EXPECT_TRUE(take({.sequence = 3, .first_scan = 40})) << "what was wrong bars nobody's way";
}

TEST_F(PacketStreamTest, RefusesEdgesOfATimeThatIsOver) {
  ASSERT_TRUE(take({}));
  // The last scan was converted up to half a microsecond, five ticks, before its instant.
  bytes = packet({.sequence = 1, .first_scan = 10}, {{-1005, 1, board::PacketEdgeKind::kToothForward, 0}});
  EXPECT_FALSE(stream.take(bytes, 0)) << "before the last scan";
  bytes = packet({.sequence = 1, .first_scan = 10}, {{-1004, 1, board::PacketEdgeKind::kToothForward, 0}});
  EXPECT_TRUE(stream.take(bytes, 0));
  bytes = packet({.sequence = 2, .first_scan = 20, .scans = 0},
                 {{-10'000, 1, board::PacketEdgeKind::kZeroMark, 0}});
  EXPECT_FALSE(stream.take(bytes, 0)) << "before the last edge";
}

TEST_F(PacketStreamTest, CountsWhatTheBoardLost) {
  ASSERT_TRUE(take({.first_scan = 3, .scans_lost = 3}));
  ASSERT_TRUE(take({.sequence = 1, .first_scan = 20, .scans_lost = 10}));
  EXPECT_EQ(report.of(DeviceCounter::kBoardOverrun), 10);
  bytes = packet({.sequence = 2, .first_scan = 30, .scans_lost = 10},
                 {{0, 0, board::PacketEdgeKind::kLost, 5}, {0, 0, board::PacketEdgeKind::kToothForward, 0}});
  ASSERT_TRUE(stream.take(bytes, 0));
  EXPECT_EQ(report.of(DeviceCounter::kEdgesLost), 1);
}

TEST_F(PacketStreamTest, CountsConversionsThatTheBoardDroppedAsTheyCameTooSoon) {
  ASSERT_TRUE(take({.glitches = 2}));
  ASSERT_TRUE(take({.sequence = 1, .first_scan = 10, .glitches = 2}));
  ASSERT_TRUE(take({.sequence = 2, .first_scan = 20, .glitches = 7}));
  EXPECT_EQ(report.of(DeviceCounter::kGlitches), 7);
  EXPECT_EQ(report.of(DeviceCounter::kBoardOverrun), 0);
  stream.start(kToken, kPeriod, kTickHz, kBegin);  // the board counts from 0 again
  ASSERT_TRUE(take({.glitches = 1}));
  EXPECT_EQ(report.of(DeviceCounter::kGlitches), 8);
}

}  // namespace
}  // namespace roadbalance
