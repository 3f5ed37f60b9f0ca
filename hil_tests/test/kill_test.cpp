#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <random>
#include <vector>

#include "common/record/segment.hpp"
#include "common/types/clocks.hpp"
#include "hil_tests/measurement.hpp"

namespace roadbalance {
namespace {

using test::Program;

class Kill : public test::Measurement {
 protected:
  /// Seconds from now until the recorder's first acknowledgement to `node`; negative: none came.
  double first_ack_s(std::int32_t node, std::int64_t older_incarnation) {
    const auto begin = WallClock::now();
    const bool heard = bus.wait([&] { return bus.ack(node).incarnation > older_incarnation; });
    return heard ? std::chrono::duration<double>(WallClock::now() - begin).count() : -1;
  }
};

void judge_first_acks(std::vector<double> seconds) {
  std::sort(seconds.begin(), seconds.end());
  std::printf("restart to first acknowledgement, %zu restarts: p50 %.0f ms, longest %.0f ms\n",
              seconds.size(), 1e3 * seconds[seconds.size() / 2], 1e3 * seconds.back());
  if (test::full_run()) {  // the acceptance, on a machine that has nothing else to do
    EXPECT_LE(seconds.back(), 1.0);
  }
}

const std::vector<std::string> kSmallSegments{"--segment-mib", "0.25"};

// A segment that has no name yet is what a kill within a change to the next one leaves.
bool has_unnamed_segment(const std::filesystem::path& record) {
  for (const auto& entry : std::filesystem::directory_iterator(record))
    if (entry.path().extension() == ".new" && entry.path().stem().extension() == ".lcm") return true;
  return false;
}

// Looks again and again: the change takes a few milliseconds, and comes each 0.1 s.
void wait_for_a_change(const std::filesystem::path& record) {
  const auto end = WallClock::now() + std::chrono::seconds(10);
  while (!has_unnamed_segment(record) && WallClock::now() < end) {
  }
}

// Every third recorder is killed while it starts, every third when it is seen to change to the next segment,
// of which 2000 blocks a second fill ten a second, the others somewhere in the next 0.2 s of recording.
TEST_F(Kill, ARecorderKilledAgainAndAgainLosesNothing) {
  const int kills = test::full_run() ? 100 : 12;
  std::mt19937 random(1);
  Program front = node("front", "rate=20&seconds=10000");
  std::vector<double> first_acks_s;
  int within_a_change = 0;
  // On a machine that has else to do, one that hits a change may be late in coming.
  const int wanted_within_a_change = kills / 6;
  for (int k = 0; k < kills || (within_a_change < wanted_within_a_change && k < 5 * kills); ++k) {
    const std::int64_t older = bus.ack(kFront).incarnation;
    Program killed = recorder(kSmallSegments);
    if (k % 3 == 2) {
      bus.listen(1e-3 * std::uniform_int_distribution(0, 30)(random));
    } else {
      first_acks_s.push_back(first_ack_s(kFront, older));
      ASSERT_GE(first_acks_s.back(), 0) << "recorder " << k << " never acknowledged";
      ASSERT_TRUE(more_are_durable(kFront, std::uniform_int_distribution(0, 400)(random)));
      if (k % 3 == 1) wait_for_a_change(record);
    }
    killed.kill();
    within_a_change += has_unnamed_segment(record) ? 1 : 0;
  }
  judge_first_acks(first_acks_s);
  Program last = recorder(kSmallSegments);
  ASSERT_TRUE(more_are_durable(kFront, 1));
  std::printf("%d kills within a change to the next of %zu segments\n", within_a_change,
              segment_numbers(record).size());
  EXPECT_GE(within_a_change, wanted_within_a_change);
  end_well(last, {&front});
  expect_complete(1);
  expect_as_simulated("front", "seconds=10000");
}

// A segment of the usual 64 MiB, all but full: it is read before the recorder sends anything.
TEST_F(Kill, ARecorderWithALargeSegmentToReadAcknowledgesSoonAfterItsRestart) {
  constexpr std::uint64_t kLarge = 56 << 20;
  const int kills = test::full_run() ? 10 : 2;
  Program front = node("front", "rate=max&seconds=10000");
  std::vector<double> first_acks_s;
  const auto is_large = [&] {
    const auto segments = segment_numbers(record);
    return !segments.empty() && std::filesystem::file_size(segment_path(record, segments.back())) > kLarge;
  };
  // On a machine that has else to do, the next segment may have begun before the kill: there is little to
  // read.
  bool was_large = false;
  for (int tries = 0; std::ssize(first_acks_s) < kills; ++tries) {
    ASSERT_LE(tries, 5 * kills);
    const std::int64_t older = bus.ack(kFront).incarnation;
    Program killed = recorder();
    const double first_s = first_ack_s(kFront, older);
    ASSERT_GE(first_s, 0) << "recorder " << tries << " never acknowledged";
    if (was_large) first_acks_s.push_back(first_s);
    ASSERT_TRUE(bus.wait(is_large));
    killed.kill();
    was_large = is_large();
  }
  judge_first_acks(first_acks_s);
  Program last = recorder();
  ASSERT_TRUE(more_are_durable(kFront, 1));
  end_well(last, {&front});
  expect_verified(record, 1);
}

TEST_F(Kill, ANodeKilledAndRestartedIsANewEpochAndTheOldOnesEndIsDeclared) {
  Program running = recorder({"--nodes", "1", "--end-with-nodes"});
  std::int64_t durable = 0;
  {
    Program killed = node("front", "rate=20&seconds=10000");
    ASSERT_TRUE(more_are_durable(kFront, 100));
    durable = bus.ack(kFront).durable;
  }
  Program restarted = node("front", "rate=20&seconds=20");
  const auto code = running.exit_code(test::BusWatch::kPatience_s);
  const Verification verification = verify_record(record);
  // The other one lives for a second: it may be over before the first is missed.
  ASSERT_EQ(code, verification.absent.empty() ? 0 : 3);
  EXPECT_EQ(verification.verdict, Verdict::kIncomplete) << verdict_text(verification);
  EXPECT_EQ(test::check_record(record), static_cast<int>(Verdict::kIncomplete));
  ASSERT_EQ(verification.epoch.size(), 2u);
  const bool first_ended = verification.epoch[0].ended;
  const VerifiedEpoch& killed = verification.epoch[first_ended ? 1 : 0];
  const VerifiedEpoch& ended = verification.epoch[first_ended ? 0 : 1];
  EXPECT_FALSE(killed.ended);
  EXPECT_GE(killed.last_sequence, durable) << "what was acknowledged is there";
  ASSERT_FALSE(killed.gaps.empty());
  EXPECT_EQ(killed.gaps.back().cause, GapCause::kNodeCrash);
  EXPECT_EQ(killed.gaps.back().first_scan, killed.samples + killed.samples_missing);
  EXPECT_TRUE(ended.is_complete());
  EXPECT_GT(ended.samples, 0);
}

}  // namespace
}  // namespace roadbalance
