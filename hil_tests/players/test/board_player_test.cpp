#include "hil_tests/players/board_player.hpp"

#include <gtest/gtest.h>

#include "firmware/board/packet.hpp"
#include "firmware/board/protocol.hpp"

namespace roadbalance::test {
namespace {

using board::Request;
using board::SetupPacket;

constexpr double kRate_hz = 2000.0;
constexpr double kPpm = 50.0;
constexpr std::int64_t kScans = 4000;
constexpr std::uint32_t kToken = 7;

/// Scans whose first count is their number, by a converter that is 50 ppm fast, and a tooth in the middle
/// between scans 99 and 100.
NodeDrive numbered_drive() {
  NodeDrive drive;
  drive.converter_ppm = kPpm;
  const double period_ns = 1e9 / (kRate_hz * (1.0 + 1e-6 * kPpm));
  for (std::int64_t k = 0; k < kScans; ++k) {
    Scan& scan = drive.scans.emplace_back();
    scan.time = node_time_from_ns(std::llround(static_cast<double>(k) * period_ns));
    scan.counts = {static_cast<std::int32_t>(k), -static_cast<std::int32_t>(k)};
  }
  drive.edges = {{.time = node_time_from_ns(std::llround(99.5 * period_ns))}};
  return drive;
}

/// A host that starts the board and reads what it sends.
class BoardPlayerTest : public ::testing::Test {
 protected:
  void start(MachineTime asked) {
    on_bench.advance(asked);
    board::Configuration configuration;
    configuration.ticks_per_scan = static_cast<std::uint32_t>(BenchBoard::kTickHz / kRate_hz);
    configuration.filter_order = 6;
    configuration.filter_corner_hz = 200;
    configuration.encoder[0] = {.pulses_per_turn = 96};
    request(Request::kConfigure, encode(configuration));
    request(Request::kArm, encode(board::Arm{.token = kToken}));
    request(Request::kStart, encode(board::Start{.token = kToken}));
  }
  template <typename Bytes>
  void request(Request what, const Bytes& bytes) {
    const SetupPacket setup{.request_type = board::kVendorOut,
                            .request = static_cast<std::uint8_t>(what),
                            .value = 0,
                            .index = 0,
                            .length = static_cast<std::uint16_t>(bytes.size())};
    ASSERT_TRUE(on_bench.control_request(setup, bytes, {}).has_value()) << static_cast<int>(what);
  }
  /// Reads all that the board sends until `end`; fills counts_ and edge_ticks_.
  void run(MachineTime from, MachineTime end) {
    std::array<std::uint8_t, board::kTransferBytes> packet;
    for (MachineTime now = from; now <= end; now += std::chrono::milliseconds(1)) {
      on_bench.advance(now);
      while (const std::size_t size = on_bench.next_packet(packet)) take(std::span(packet).first(size));
    }
  }
  void take(std::span<const std::uint8_t> packet) {
    const auto view = board::decode_packet(packet);
    ASSERT_TRUE(view.has_value());
    for (std::size_t k = 0; k < view->header().scans; ++k) {
      first_count.push_back(view->scan(k).counts[0]);
      ASSERT_EQ(view->scan(k).counts[1], -view->scan(k).counts[0]);
      ticks.push_back(view->header().base_ticks + k * view->header().ticks_per_scan);
    }
    for (std::size_t k = 0; k < view->header().edges; ++k)
      edge_ticks.push_back(view->header().base_ticks +
                           static_cast<std::uint64_t>(std::int64_t{view->edge(k).offset_ticks}));
  }

  const MachineTime begin = MachineClock::now() + std::chrono::seconds(3);
  PulseProgram program;
  BoardPlayer player{numbered_drive(),
                     [this] {
                       program.add(numbered_drive(), 0, 0, 1);
                       return program.take();
                     }(),
                     Timetable{begin, {}}};
  BenchBoard on_bench{player.bench("TEST")};
  std::vector<std::int32_t> first_count;
  std::vector<std::uint64_t> ticks, edge_ticks;
};

TEST_F(BoardPlayerTest, EveryScanHasItsConversionAtItsInstantBetweenSilence) {
  const MachineTime asked = begin - std::chrono::microseconds(1'234'567);
  start(asked);
  run(asked, begin + std::chrono::milliseconds(2100));
  std::size_t lead = 0;
  while (lead < first_count.size() && first_count[lead + 1] == 0) ++lead;
  EXPECT_NEAR(static_cast<double>(lead), 1.2345 * kRate_hz, 2.0) << "conversions before the drive";
  ASSERT_GE(first_count.size(), lead + kScans + 10U);
  for (std::int64_t k = 0; k < kScans; ++k) ASSERT_EQ(first_count[lead + static_cast<std::size_t>(k)], k);
  for (std::size_t k = lead + kScans; k < first_count.size(); ++k) ASSERT_EQ(first_count[k], 0);
  EXPECT_EQ(player.played(), kScans);
  // Scan 0 is at `begin` within a tick of 100 ns.
  const MachineTime scan_0 = on_bench.conversion_time(static_cast<std::int64_t>(lead));
  EXPECT_LE(std::chrono::abs(scan_0 - begin).count(), 100);
}

TEST_F(BoardPlayerTest, TeethKeepTheirPlaceBetweenTheScans) {
  start(begin - std::chrono::milliseconds(500));
  run(begin - std::chrono::milliseconds(500), begin + std::chrono::milliseconds(100));
  ASSERT_EQ(edge_ticks.size(), 1U);
  std::size_t scan_99 = 0;
  while (first_count[scan_99] != 99) ++scan_99;
  EXPECT_NEAR(static_cast<double>(edge_ticks[0] - ticks[scan_99]), 2500.0, 2.0) << "ticks, half a period";
}

// After a replug the board converts what the car does by then.
TEST_F(BoardPlayerTest, ARestartedBoardSeesTheDriveGoOn) {
  const MachineTime late = begin + std::chrono::microseconds(1'000'200);
  start(late);
  run(late, late + std::chrono::milliseconds(100));
  ASSERT_GT(first_count.size(), 100U);
  EXPECT_NEAR(first_count[0], 2002, 1) << "the next but one after the restart";
  for (std::size_t k = 1; k < first_count.size(); ++k) ASSERT_EQ(first_count[k], first_count[k - 1] + 1);
  EXPECT_EQ(player.played(), 0) << "not from its beginning";
}

}  // namespace
}  // namespace roadbalance::test
