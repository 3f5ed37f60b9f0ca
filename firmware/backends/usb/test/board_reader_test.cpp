#include "firmware/backends/usb/board_reader.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/test/no_allocation.hpp"
#include "firmware/backends/usb/test/counting_bench.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
using test::as_node;
using test::Bench;
using test::bench;
using test::BoardFeed;
using test::counts_of;
using test::kRateHz;
using test::kTeeth;
using test::LineChange;
using test::vehicle;

constexpr double kTurns_per_s = 12.0;

/// A wheel that turns evenly from the start, on line 0: teeth, and one zero mark a turn between two of them.
class Wheel {
 public:
  std::optional<LineChange> operator()() {
    const int part = static_cast<int>(change_ % 4);
    const auto tooth = static_cast<double>(change_++ / 4);
    const bool mark = part >= 2;
    const double tooth_s = 1.0 / (kTurns_per_s * kTeeth);
    const double at_s = tooth_s * (tooth + 0.2 * part + 0.1);
    const bool marked = !mark || static_cast<std::int64_t>(tooth) % kTeeth == 0;
    return LineChange{start + std::chrono::nanoseconds(std::llround(1e9 * at_s)), 0,
                      mark ? board::Signal::kZero : board::Signal::kA, part % 2 == 0 && marked};
  }
  MachineTime start = test::kPowered + 50s;

 private:
  std::int64_t change_ = 0;
};

TEST(BoardReader, GivesEveryScanOnceWithItsCountsAndTheTimeOfItsConversion) {
  BoardFeed feed({bench(70.0)}, vehicle());
  feed.begin();
  feed.run(20s);
  ASSERT_GE(feed.scans.size(), 199'900u);
  for (std::size_t k = 0; k < feed.scans.size(); ++k) {
    const Scan& scan = feed.scans[k];
    ASSERT_EQ(scan.index, static_cast<std::int64_t>(k));
    ASSERT_EQ(scan.overload, 0u);
    ASSERT_FALSE(scan.after_absence);
    for (std::size_t c = 0; c < kAccelerations; ++c) ASSERT_EQ(scan.counts[c], counts_of(scan.index, c));
    // Packets arrive up to half a millisecond after their last scan (the steps of this test's time), but the
    // least of a second's is what counts; before there is a rate, 70 ppm of four seconds come to it.
    const auto true_time = as_node(feed.board().conversion_time(scan.index));
    ASSERT_NEAR(to_seconds(scan.time - true_time), 0.0, k < 50'000 ? 350e-6 : 60e-6) << k;
  }
}

TEST(BoardReader, TellsWhichChannelsLeftTheirRange) {
  Bench bench;
  bench.words = [](std::int64_t conversion, MachineTime) {
    board::ScanWords words{};
    if (conversion == 100) words[5] = 0x7FFFFF;
    if (conversion == 200) words[11] = 0x800000;
    return words;
  };
  BoardFeed feed({std::move(bench)}, vehicle());
  feed.begin();
  feed.run(100ms);
  ASSERT_GT(feed.scans.size(), 300u);
  for (const Scan& scan : feed.scans)
    EXPECT_EQ(scan.overload, scan.index == 100 ? 1u << 5 : scan.index == 200 ? 1u << 11 : 0u);
  EXPECT_EQ(feed.scans[200].counts[11], -(1 << 23));
}

TEST(BoardReader, GivesEdgesBeforeTheScansThatFollowThemHoweverLittleRoomThereIs) {
  Bench wheel = bench();
  wheel.next_change = Wheel();
  BoardFeed feed({std::move(wheel)}, vehicle());
  feed.scans_at_once = 7;
  feed.edges_at_once = 3;
  feed.begin();
  feed.run(3s);
  std::size_t teeth = 0, marks = 0;
  for (const Edge& edge : feed.edges) {
    EXPECT_EQ(edge.line, 0);
    const double tooth_s = 1.0 / (kTurns_per_s * kTeeth);
    const bool is_mark = edge.kind == EdgeKind::kZeroMark;
    ASSERT_TRUE(is_mark || edge.kind == EdgeKind::kTooth);
    const double number =
        is_mark ? static_cast<double>(kTeeth * marks) + 0.5 : static_cast<double>(teeth) + 0.1;
    ASSERT_NEAR(to_seconds(edge.time - as_node(Wheel().start)), number * tooth_s, 1e-6);
    ++(is_mark ? marks : teeth);
  }
  EXPECT_NEAR(static_cast<double>(teeth), 3.0 * kTurns_per_s * kTeeth, 10.0);
  EXPECT_EQ(marks, 36u);
}

TEST(BoardReader, CountsTheScansOfAnAbsenceByItsTime) {
  for (const double ppm : {0.0, 90.0}) {
    Bench wheel = bench(ppm);
    wheel.next_change = Wheel();
    BoardFeed feed({std::move(wheel)}, vehicle());
    feed.begin();
    feed.run(15s);
    const std::size_t before = feed.scans.size(), edges_before = feed.edges.size();
    const NodeTime last_time = as_node(feed.board().conversion_time(feed.scans.back().index));
    feed.absent(777'777us);
    feed.begin();
    feed.run(100ms);
    ASSERT_GT(feed.scans.size(), before + 100);
    const Scan& last = feed.scans[before - 1];
    const Scan& next = feed.scans[before];
    EXPECT_TRUE(next.after_absence);
    EXPECT_FALSE(feed.scans[before + 1].after_absence);
    EXPECT_EQ(feed.scans[before + 1].index, next.index + 1);
    // The same as if the board's timer had gone on.
    const double passed_s = to_seconds(as_node(feed.board().conversion_time(0)) - last_time);
    EXPECT_NEAR(static_cast<double>(next.index - last.index), passed_s * kRateHz * (1.0 + 1e-6 * ppm), 1.0);
    EXPECT_EQ(feed.edges[edges_before].kind, EdgeKind::kLost);
    EXPECT_GT(feed.edges[edges_before].time, last.time);
    EXPECT_EQ(next.counts[0], counts_of(0, 0)) << "the board began anew";
  }
}

TEST(BoardReader, LostPacketsAreAHoleInTheNumbersAndInTheEdges) {
  Bench wheel = bench();
  wheel.next_change = Wheel();
  BoardFeed feed({std::move(wheel)}, vehicle());
  feed.begin();
  feed.run(500ms);
  const std::size_t before = feed.scans.size(), edges_before = feed.edges.size();
  feed.run(50ms, true);
  feed.run(50ms);
  ASSERT_GT(feed.scans.size(), before);
  EXPECT_NEAR(static_cast<double>(feed.scans[before].index - feed.scans[before - 1].index), 500.0, 55.0);
  EXPECT_FALSE(feed.scans[before].after_absence);
  for (std::size_t k = before; k < feed.scans.size(); ++k)
    ASSERT_EQ(feed.scans[k].counts[0], counts_of(feed.scans[k].index, 0));
  EXPECT_EQ(feed.edges[edges_before].kind, EdgeKind::kLost);
  EXPECT_NE(feed.edges[edges_before + 2].kind, EdgeKind::kLost) << "one for each line";
  EXPECT_NEAR(static_cast<double>(feed.report().of(DeviceCounter::kPacketsMissing)), 10.0, 2.0);
}

TEST(BoardReader, AStampThatCannotBeIsAHoleInTheNumbersAndInTheEdges) {
  Bench wheel = bench();
  wheel.next_change = Wheel();
  BoardFeed feed({std::move(wheel)}, vehicle());
  feed.begin();
  feed.run(500ms);
  const std::size_t before = feed.scans.size(), edges_before = feed.edges.size();
  feed.shift_ticks = 10ull * test::BenchBoard::kTickHz;  // of a packet, ten seconds ahead
  feed.run(50ms);
  ASSERT_EQ(feed.report().of(DeviceCounter::kPacketsRefused), 1);
  ASSERT_GT(feed.scans.size(), before);
  EXPECT_NEAR(static_cast<double>(feed.scans[before].index - feed.scans[before - 1].index), 55.0, 5.0)
      << "one packet";
  EXPECT_EQ(feed.edges[edges_before].kind, EdgeKind::kLost);
  EXPECT_EQ(feed.edges[edges_before + 1].kind, EdgeKind::kLost) << "one for each line";
  EXPECT_EQ(feed.edges[edges_before + 2].kind, EdgeKind::kTooth);
  EXPECT_EQ(feed.report().of(DeviceCounter::kPacketsMissing), 0);
}

TEST(BoardReader, AnEdgeBehindAScanThatCameEarlyDoesNotComeBeforeIt) {
  DeviceReport report("usb:test");
  BoardReader reader({&report}, kRateHz, 12, {true, true});
  BoardDelivery delivery;
  delivery.kind = BoardDelivery::Kind::kRunBegin;
  constexpr std::uint32_t kTicks = test::BenchBoard::kTickHz / 10'000;
  delivery.run = {.token = 1,
                  .ticks_per_scan = {kTicks, 0},
                  .tick_hz = {test::BenchBoard::kTickHz, 0},
                  .begin = {BoardInstant{0, node_time_from_ns(0)}, {}}};
  reader.take(delivery);
  delivery.kind = BoardDelivery::Kind::kTransfer;
  std::array<Scan, 8> scans;
  std::array<Edge, 64> edges;
  Read read;
  for (std::uint32_t sequence = 0; sequence < 2; ++sequence) {
    // The edge is stamped 0.3 us before the nominal instant of the scan of the packet before.
    const std::size_t with_edges = sequence;
    const board::PacketHeader header{.token = 1,
                                     .sequence = sequence,
                                     .first_scan = sequence,
                                     .base_ticks = (sequence + 1) * kTicks,
                                     .ticks_per_scan = kTicks,
                                     .scans = 1,
                                     .edges = static_cast<std::uint16_t>(with_edges)};
    const auto all = std::span(delivery.bytes).first(board::packet_bytes(1, with_edges));
    board::encode_header(header, all.first<board::kHeaderBytes>());
    board::encode_scan({}, all.subspan<board::kHeaderBytes, board::kScanBytes>());
    if (with_edges > 0)
      board::encode_edge({-static_cast<std::int32_t>(kTicks) - 3, 0, board::PacketEdgeKind::kToothForward, 0},
                         all.subspan<board::kHeaderBytes + board::kScanBytes, board::kEdgeBytes>());
    board::seal_packet(all);
    delivery.size = static_cast<std::uint32_t>(all.size());
    delivery.arrival = node_time_from_ns(100'000 * (sequence + 1));
    reader.take(delivery);
    EXPECT_TRUE(reader.hand_over(scans, edges, read));
  }
  EXPECT_EQ(report.of(DeviceCounter::kPacketsRefused), 0);
  ASSERT_EQ(read.scans, 2u);
  ASSERT_EQ(read.edges, 1u);
  EXPECT_GT(edges[0].time, scans[0].time);
  EXPECT_LT(to_seconds(edges[0].time - scans[0].time), 1e-6);
}

TEST(BoardReader, ReferencesComeBackAsSineAndCosineOfTheWheel) {
  VehicleConfig car = vehicle();
  car.node[0].wiring.loop_back = true;
  Bench wheel = bench();
  wheel.next_change = Wheel();
  BoardFeed feed({std::move(wheel)}, car);
  feed.begin();
  feed.run(3s);
  const double first_mark_s = 0.5 / (kTurns_per_s * kTeeth);
  for (std::size_t k = 20'000; k < feed.scans.size(); ++k) {
    const Scan& scan = feed.scans[k];
    const double angle =
        2.0 * M_PI * kTurns_per_s * (to_seconds(scan.time - as_node(Wheel().start)) - first_mark_s);
    // The D/A holds the value of the middle of each period, and is read half a period later than that: 0.4
    // mrad of the wheel; the mark is known to a tick.
    ASSERT_NEAR(scan.references[0] / static_cast<double>(kFullScaleCounts), std::sin(angle), 6e-3) << k;
    ASSERT_NEAR(scan.references[1] / static_cast<double>(kFullScaleCounts), std::cos(angle), 6e-3) << k;
    ASSERT_EQ(scan.references[2], 0);
  }
}

TEST(BoardReader, NeverAllocates) {
  Bench wheel = bench();
  wheel.next_change = Wheel();
  BoardFeed feed({std::move(wheel)}, vehicle());
  feed.scans.reserve(100'000);
  feed.edges.reserve(100'000);
  feed.begin();
  const test::NoAllocation guard;
  feed.run(1s);
}

}  // namespace
}  // namespace roadbalance
