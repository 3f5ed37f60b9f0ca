#include "firmware/board/board.hpp"

#include "firmware/board/test/check.hpp"
#include "firmware/board/test/rig.hpp"

namespace roadbalance::board::test {
namespace {

// A host checks of every packet of a run: nothing missing but what is declared.
struct Stream {
  std::uint32_t sequence = 0;
  std::uint64_t next_scan = 0;
  std::uint64_t holes = 0;
  std::uint64_t scans = 0;
  std::uint64_t edges = 0;
  std::uint64_t last_scan_ticks = 0;
  bool edges_in_time = true;

  void take(const PacketView& packet) {
    const PacketHeader& header = packet.header();
    CHECK_EQUAL(header.token, Rig::kToken);
    CHECK_EQUAL(header.sequence, sequence);
    ++sequence;
    CHECK(header.first_scan >= next_scan);
    CHECK_EQUAL((header.flags & kScansLostBefore) != 0, header.first_scan != next_scan);
    holes += header.first_scan - next_scan;
    next_scan = header.first_scan + header.scans;
    scans += header.scans;
    edges += header.edges;
    for (std::size_t k = 0; k < header.edges; ++k) {
      const std::uint64_t ticks =
          header.base_ticks + static_cast<std::uint64_t>(std::int64_t{packet.edge(k).offset_ticks});
      edges_in_time = edges_in_time && ticks > last_scan_ticks;
    }
    if (header.scans > 0)
      last_scan_ticks = header.base_ticks + (header.scans - 1u) * std::uint64_t{header.ticks_per_scan};
  }
};

void scan_at(Rig& rig, std::uint64_t ticks, std::uint32_t base = 0) {
  rig.hardware.now = ticks;
  rig.board.scan(words_from(base), 0, ticks);
}

Configuration with_encoders() {
  Configuration configuration = test_configuration();
  configuration.encoder = {{{96, 0}, {1000, 0}}};
  return configuration;
}

}  // namespace

BOARD_TEST(board_streams_without_gaps_every_word_it_was_given) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(test_configuration()));
  Stream stream;
  std::uint64_t checked = 0;
  for (std::uint32_t k = 0; k < 5'000; ++k) {
    scan_at(rig, std::uint64_t{k + 1} * kTicksPerScan, k * 0x10001);
    const auto packet = rig.packet();
    if (!packet) continue;
    stream.take(*packet);
    CHECK_EQUAL(packet->header().base_ticks, (packet->header().first_scan + 1) * kTicksPerScan);
    for (std::size_t n = 0; n < packet->header().scans; ++n, ++checked) {
      const ScanWords words = words_from(static_cast<std::uint32_t>(checked) * 0x10001);
      const PacketScan scan = packet->scan(n);
      for (std::size_t c = 0; c < kInputChannels; ++c) CHECK_EQUAL(scan.counts[c] & 0xFFFFFF, words[c]);
      for (std::size_t c = kInputChannels; c < kStreamChannels; ++c) CHECK_EQUAL(scan.counts[c], 0);
    }
  }
  // 5 ms are 50 periods; the packet goes out with the 51st scan.
  CHECK_EQUAL(stream.sequence, 5'000 / 51);
  CHECK_EQUAL(stream.scans, 5'000 / 51 * 51);
  CHECK_EQUAL(stream.holes, 0);
  CHECK_EQUAL(rig.status().packets, stream.sequence);
  CHECK_EQUAL(rig.status().scans, stream.next_scan);
}

BOARD_TEST(board_says_a_counter_as_test_pattern) {
  Rig& rig = Rig::fresh();
  CHECK(rig.send(Request::kTestPattern, encode(TestPattern{Pattern::kCounter})));
  CHECK(rig.begin(test_configuration()));
  for (std::uint64_t k = 1; k <= 51; ++k) scan_at(rig, k * kTicksPerScan, 0x7FFFFF);
  const auto packet = rig.packet();
  REQUIRE(packet && packet->header().scans == 51);
  CHECK_EQUAL(packet->header().flags, kPatternOn);
  for (int n = 0; n < 51; ++n)
    for (int c = 0; c < 16; ++c)
      CHECK_EQUAL(packet->scan(static_cast<std::size_t>(n)).counts[static_cast<std::size_t>(c)], 16 * n + c);
}

BOARD_TEST(board_flags_an_overload_in_its_scan_and_packet) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(test_configuration()));
  for (std::uint64_t k = 1; k <= 51; ++k) {
    rig.hardware.now = k * kTicksPerScan;
    rig.board.scan(ScanWords{}, k == 11 ? 0x801 : 0, rig.hardware.now);
  }
  const auto packet = rig.packet();
  REQUIRE(packet && packet->header().scans == 51);
  CHECK_EQUAL(packet->header().flags, kOverload);
  CHECK_EQUAL(packet->header().overloads, 1);
  for (std::size_t n = 0; n < 51; ++n) CHECK_EQUAL(packet->scan(n).overload, n == 10 ? 0x801 : 0);
}

BOARD_TEST(board_sends_every_edge_with_or_before_the_next_scan) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(with_encoders()));
  Stream stream;
  std::uint64_t sent = 0;
  std::uint64_t edge_ticks = 100;
  for (std::uint64_t k = 1; k <= 4'000; ++k) {
    const std::uint64_t ticks = k * kTicksPerScan;
    // 33 kHz and, each third, on the instant of a conversion itself.
    for (; edge_ticks <= ticks; edge_ticks += 3'000, ++sent) {
      const std::uint64_t at = edge_ticks + 2'900 > ticks ? ticks : edge_ticks;
      rig.board.line_change(sent % 2, Signal::kA, true, at);
    }
    scan_at(rig, ticks);
    while (const auto packet = rig.packet()) stream.take(*packet);
  }
  rig.hardware.now += kTickHz;
  while (const auto packet = rig.packet()) {
    stream.take(*packet);
    if (packet->header().scans == 0) break;
  }
  CHECK_EQUAL(stream.scans, 4'000);
  CHECK_EQUAL(stream.edges, sent);
  CHECK(stream.edges_in_time);
  CHECK_EQUAL(rig.status().edges_lost, 0);
}

BOARD_TEST(board_whose_host_does_not_read_declares_exactly_what_is_lost) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(with_encoders()));
  Stream stream;
  std::uint64_t ticks = 0;
  std::uint64_t given_edges = 0;
  int flagged = 0;
  const auto run = [&](int scans, bool reads) {
    for (int k = 0; k < scans; ++k) {
      for (int n = 1; n <= 2; ++n, ++given_edges)
        rig.board.line_change(0, Signal::kA, true, ticks + static_cast<std::uint64_t>(n) * 3'000);
      scan_at(rig, ticks += kTicksPerScan);
      while (reads) {
        const auto packet = rig.packet();
        if (!packet) break;
        stream.take(*packet);
        flagged += (packet->header().flags & kEdgesLostHere) != 0 ? 1 : 0;
      }
    }
  };
  run(500, true);
  run(4'000, false);
  run(500, true);
  const Status status = rig.status();
  CHECK(status.scans_lost > 1'000);
  CHECK_EQUAL(stream.holes, status.scans_lost);
  CHECK(status.edges_lost > 1'000);
  CHECK_EQUAL(flagged, 1);
  // Edges not yet sent are less than a packet; the mark that declares the loss counts as one more edge.
  CHECK(5'000 - status.scans_lost - stream.scans <= 51);
  CHECK(given_edges - status.edges_lost - (stream.edges - 1) <= 2 * 51);
  CHECK(stream.edges_in_time);
}

BOARD_TEST(board_begins_a_new_packet_behind_a_conversion_that_did_not_come) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(test_configuration()));
  for (std::uint64_t k = 1; k <= 60; ++k)
    if (k < 21 || k > 23) scan_at(rig, k * kTicksPerScan);
  const auto first = rig.packet();
  REQUIRE(first.has_value());
  CHECK_EQUAL(first->header().scans, 20);
  rig.hardware.now += kTickHz / 100;
  const auto second = rig.packet();
  REQUIRE(second.has_value());
  CHECK_EQUAL(second->header().first_scan, 23);
  CHECK_EQUAL(second->header().base_ticks, 24 * kTicksPerScan);
  CHECK_EQUAL(second->header().flags, kScansLostBefore);
  CHECK_EQUAL(second->header().scans_missed, 3);
  CHECK_EQUAL(second->header().scans_lost, 0);
}

// 0.5 us are 50 ticks.
BOARD_TEST(board_begins_a_new_packet_when_a_scan_is_not_where_its_number_has_it) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(test_configuration()));
  for (std::uint64_t k = 1; k <= 60; ++k)
    scan_at(rig, k * kTicksPerScan + (k > 10 ? 50 : 0) + (k > 20 ? 1 : 0));
  const auto first = rig.packet();
  REQUIRE(first.has_value());
  CHECK_EQUAL(first->header().scans, 20);
  rig.hardware.now += kTickHz / 100;
  const auto second = rig.packet();
  REQUIRE(second.has_value());
  CHECK_EQUAL(second->header().first_scan, 20);
  CHECK_EQUAL(second->header().base_ticks, 21 * kTicksPerScan + 51);
  CHECK_EQUAL(second->header().flags, 0);
}

BOARD_TEST(board_declares_an_edge_that_comes_behind_its_scan_as_lost) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(with_encoders()));
  scan_at(rig, kTicksPerScan);
  rig.board.line_change(0, Signal::kA, true, kTicksPerScan - 1);
  CHECK_EQUAL(rig.status().edges_lost, 1);
}

BOARD_TEST(board_fills_a_late_hosts_packets_but_never_beyond_their_size) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(with_encoders()));
  std::uint64_t ticks = 0;
  for (int k = 0; k < 400; ++k) {
    for (std::uint64_t n = 1; n <= 2; ++n) rig.board.line_change(1, Signal::kA, true, ticks + n);
    scan_at(rig, ticks += kTicksPerScan);
  }
  // A scan and its two edges: 66 bytes.
  const std::size_t fit = (kMaxPacketBytes - kHeaderBytes - kCrcBytes) / (kScanBytes + 2 * kEdgeBytes);
  const auto packet = rig.packet();
  REQUIRE(packet.has_value());
  CHECK_EQUAL(packet->header().scans, fit);
  CHECK_EQUAL(packet->header().edges, 2 * fit);
}

BOARD_TEST(board_sends_more_edges_than_fit_one_packet_ahead_of_their_scan) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(with_encoders()));
  Stream stream;
  for (std::uint64_t n = 1; n <= 1'024; ++n) rig.board.line_change(0, Signal::kA, true, n);
  scan_at(rig, kTicksPerScan);
  const auto full = rig.packet();
  REQUIRE(full.has_value());
  stream.take(*full);
  CHECK_EQUAL(full->header().scans, 0);
  rig.hardware.now += kTickHz / 100;
  const auto rest = rig.packet();
  REQUIRE(rest.has_value());
  stream.take(*rest);
  CHECK_EQUAL(rest->header().scans, 1);
  CHECK_EQUAL(stream.edges, 1'024);
}

BOARD_TEST(board_that_has_nothing_says_so_each_100_ms) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(test_configuration()));
  CHECK(!rig.packet());
  rig.hardware.now = kTickHz / 10 - 1;
  CHECK(!rig.packet());
  rig.hardware.now = kTickHz / 10;
  const auto packet = rig.packet();
  REQUIRE(packet.has_value());
  CHECK_EQUAL(packet->header().scans + packet->header().edges, 0);
  CHECK_EQUAL(packet->header().base_ticks, rig.hardware.now);
  CHECK(!rig.packet());
}

BOARD_TEST(board_begins_each_run_anew) {
  Rig& rig = Rig::fresh();
  CHECK(rig.begin(with_encoders()));
  for (std::uint64_t k = 1; k <= 3'000; ++k) scan_at(rig, k * kTicksPerScan);
  CHECK(rig.status().scans_lost > 0);
  CHECK(rig.stop());
  CHECK(!rig.packet());
  scan_at(rig, 3'001 * kTicksPerScan);
  for (std::uint64_t n = 0; n < 2'000; ++n) rig.board.line_change(0, Signal::kA, true, rig.hardware.now + n);
  CHECK(!rig.packet());
  CHECK_EQUAL(rig.status().edges_lost, 0);
  CHECK(rig.begin(with_encoders()));
  for (std::uint64_t k = 1; k <= 51; ++k) scan_at(rig, rig.hardware.now + kTicksPerScan);
  const auto packet = rig.packet();
  REQUIRE(packet.has_value());
  CHECK_EQUAL(packet->header().sequence, 0);
  CHECK_EQUAL(packet->header().first_scan, 0);
  CHECK_EQUAL(packet->header().scans, 51);
  CHECK_EQUAL(packet->header().scans_lost, 0);
}

}  // namespace roadbalance::board::test
