#include "common/link/test/link_simulation.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace roadbalance {
namespace {

using test::LinkOutcome;
using test::LinkScenario;
using test::LinkSimulation;

// RB_LINK_SEEDS=200 for a thorough run.
std::uint64_t seeds() {
  const char* asked = std::getenv("RB_LINK_SEEDS");
  return asked ? std::stoull(asked) : 2;
}

void expect_no_fault(const LinkOutcome& outcome, std::uint64_t seed) {
  ASSERT_TRUE(outcome.faults.empty())
      << outcome.faults.size() << " faults with seed " << seed << ", the first: " << outcome.faults.front();
}

// Without kills nothing may be missing at all.
void expect_all_recorded(const LinkScenario& scenario) {
  for (std::uint64_t seed = 1; seed <= seeds(); ++seed) {
    const LinkOutcome outcome = LinkSimulation(scenario, seed).run();
    expect_no_fault(outcome, seed);
    EXPECT_GT(outcome.sealed, 1000);
    EXPECT_EQ(outcome.recorded, outcome.sealed) << "seed " << seed;
    ::testing::Test::RecordProperty(
        "sends_a_block",
        std::to_string(static_cast<double>(outcome.transmissions) / static_cast<double>(outcome.sealed)));
    ::testing::Test::RecordProperty("longest_to_durable_s", std::to_string(outcome.longest_to_durable_s));
  }
}

TEST(Link, RecordsEverythingOverAPerfectNetwork) {
  expect_all_recorded({});
}

TEST(Link, RepairsThirtyPercentLossWithDuplicatesAndReordering) {
  expect_all_recorded({.loss = 0.3, .duplicates = 0.05});
}

TEST(Link, RepairsSixtyPercentLoss) {
  expect_all_recorded({.loss = 0.6, .duplicates = 0.05});
}

TEST(Link, LosesNothingWhenTheCableIsPulledForTenSeconds) {
  expect_all_recorded({.seconds = 16, .loss = 0.3, .cable_out_s = 4, .cable_in_s = 14});
}

TEST(Link, LosesNothingWhenTheRecorderIsKilledAgainAndAgain) {
  expect_all_recorded({.seconds = 20, .loss = 0.3, .duplicates = 0.05, .recorder_kills = 10});
}

TEST(Link, LosesNothingWhenSyncsStall) {
  expect_all_recorded({.loss = 0.1, .slow_syncs = 0.1});
}

// 64 slots at 250 blocks a second: the ring wraps many times and is full now and then.
TEST(Link, LosesNothingThroughASmallRing) {
  expect_all_recorded({.loss = 0.3, .duplicates = 0.05, .ring_bytes = 100 * sizeof(SealedBlock)});
}

TEST(Link, DeclaresWhatDiedWithANodeAndNothingElse) {
  for (std::uint64_t seed = 1; seed <= seeds(); ++seed) {
    const LinkOutcome outcome =
        LinkSimulation({.seconds = 20, .loss = 0.2, .recorder_kills = 4, .node_kills = 3}, seed).run();
    expect_no_fault(outcome, seed);
    EXPECT_EQ(outcome.recorded + outcome.declared, outcome.sealed) << "seed " << seed;
    EXPECT_GT(outcome.recorded, outcome.sealed / 2);
  }
}

TEST(Link, SendsAboutAsOftenAsTheLossDemands) {
  const LinkOutcome outcome = LinkSimulation({.loss = 0.3}, 7).run();
  const double sends_a_block =
      static_cast<double>(outcome.transmissions) / static_cast<double>(outcome.sealed);
  // No protocol does better than 1 / (1 - 0.3) = 1.43; a tenth more is allowed for late answers.
  EXPECT_LT(sends_a_block, 1.1 / (1 - 0.3));
}

}  // namespace
}  // namespace roadbalance
