#include "firmware/board/board.hpp"
#include "firmware/board/test/check.hpp"
#include "firmware/board/test/rig.hpp"

// Two boards in one node: the follower converts with the master's SYNC.
namespace roadbalance::board::test {
namespace {

// The follower's timer runs 40 ppm fast and began elsewhere.
std::uint64_t follower_ticks(std::uint64_t master_ticks) {
  return 777'777 + master_ticks + master_ticks / 25'000;
}

struct Pair {
  Rig& master = Rig::fresh(0);
  Rig& follower = Rig::fresh(1);
  std::uint64_t ticks = 0;

  bool begin() {
    return follower.begin(test_configuration(), StartMode::kFollower) &&
           master.begin(test_configuration(), StartMode::kMaster);
  }
  // One conversion of both, of a signal whose value is its number.
  void convert(std::uint32_t truth, bool sync_arrives = true) {
    ticks += kTicksPerScan;
    master.hardware.now = ticks;
    master.board.scan(words_from(truth), 0, ticks);
    follower.hardware.now = follower_ticks(ticks);
    if (sync_arrives) follower.board.scan(words_from(truth), 0, follower.hardware.now);
  }
};

// Checks that the scan of this number carries the signal of this number.
std::uint64_t check_alignment(const PacketView& packet) {
  for (std::size_t k = 0; k < packet.header().scans; ++k)
    CHECK_EQUAL(packet.scan(k).counts[0], packet.header().first_scan + k);
  return packet.header().scans;
}

}  // namespace

BOARD_TEST(follower_starts_with_its_master_at_the_same_scan_and_stays) {
  Pair pair;
  REQUIRE(pair.begin());
  CHECK_EQUAL(pair.follower.status().state, State::kArmed);
  CHECK(!pair.follower.packet());
  std::uint64_t of_master = 0;
  std::uint64_t of_follower = 0;
  // 40 ppm are a whole period in 25'000 scans: without SYNC they would be apart by two.
  for (std::uint32_t k = 0; k < 50'000; ++k) {
    pair.convert(k);
    if (const auto packet = pair.master.packet()) of_master += check_alignment(*packet);
    if (const auto packet = pair.follower.packet()) {
      of_follower += check_alignment(*packet);
      const std::uint64_t truth = follower_ticks((packet->header().first_scan + 1) * kTicksPerScan);
      CHECK_EQUAL(packet->header().base_ticks, truth);
    }
  }
  CHECK(of_master > 49'900 && of_follower > 49'900);
  CHECK_EQUAL(pair.follower.status().scans_missed, 0);
  CHECK_EQUAL(pair.follower.status().state, State::kRunning);
}

BOARD_TEST(follower_keeps_its_numbers_over_lost_and_doubled_edges_of_sync) {
  Pair pair;
  REQUIRE(pair.begin());
  for (std::uint32_t k = 0; k < 2'000; ++k) {
    pair.convert(k, k % 100 != 50);
    if (k % 100 == 70)  // a glitch right behind the edge
      pair.follower.board.scan(words_from(0), 0, pair.follower.hardware.now + 20);
    if (const auto packet = pair.follower.packet()) check_alignment(*packet);
  }
  CHECK_EQUAL(pair.follower.status().scans_missed, 20);
  CHECK_EQUAL(pair.follower.status().glitches, 20);
}

BOARD_TEST(follower_ends_its_run_behind_too_long_a_silence_of_sync) {
  Pair pair;
  REQUIRE(pair.begin());
  for (std::uint32_t k = 0; k < 30; ++k) pair.convert(k);
  for (std::uint32_t k = 30; k < 2'600; ++k) pair.convert(k, false);
  CHECK_EQUAL(pair.follower.status().state, State::kRunning);
  pair.convert(2'600);
  CHECK_EQUAL(pair.follower.status().state, State::kLost);
  const auto rest = pair.follower.packet();
  REQUIRE(rest.has_value());
  CHECK_EQUAL(check_alignment(*rest), 30);
  pair.follower.hardware.now += kTickHz;
  CHECK(!pair.follower.packet());
  CHECK(!pair.follower.send(Request::kArm, encode(Arm{1, StartMode::kFollower})));
  CHECK(pair.follower.stop());
  CHECK(pair.follower.send(Request::kArm, encode(Arm{1, StartMode::kFollower})));
}

BOARD_TEST(follower_keeps_edges_from_its_first_scan_on) {
  Rig& rig = Rig::fresh();
  Configuration configuration = test_configuration();
  configuration.encoder[0] = {96, 0};
  REQUIRE(rig.begin(configuration, StartMode::kFollower));
  for (std::uint64_t k = 1; k <= 2'000; ++k) rig.board.line_change(0, Signal::kA, true, k * 100);
  CHECK_EQUAL(rig.status().edges_lost, 0);
  rig.board.scan(ScanWords{}, 0, 1'000'000);
  rig.board.line_change(0, Signal::kA, true, 1'000'100);
  rig.hardware.now = 1'000'000 + kTickHz;
  const auto packet = rig.packet();
  REQUIRE(packet.has_value());
  CHECK_EQUAL(packet->header().scans, 1);
  const auto next = rig.packet();
  REQUIRE(next.has_value());
  CHECK_EQUAL(next->header().edges, 1);
}

}  // namespace roadbalance::board::test
