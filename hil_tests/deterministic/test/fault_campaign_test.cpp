#include "hil_tests/deterministic/fault_campaign.hpp"

#include <gtest/gtest.h>

#include <string>

namespace roadbalance::test {
namespace {

FaultScenario all_faults() {
  return FaultScenario::read_file(RB_SCENARIOS "/everything.toml");
}

CampaignOptions seeds(std::uint64_t first, std::int64_t count, int jobs = 1) {
  CampaignOptions options;
  options.first_seed = first;
  options.seeds = count;
  options.jobs = jobs;
  options.seconds = 60;
  return options;
}

// But for the processor's time, which has no bound.
bool is_the_same(RunResult a, RunResult b) {
  a.processor_s = b.processor_s = 0;
  return a == b;
}

TEST(FaultCampaign, OneSeedIsOneRunInWhicheverProcessAndBehindWhicheverOther) {
  const FaultScenario scenario = all_faults();
  const auto in_turn = run_seeds(scenario, seeds(7, 3));
  const auto side_by_side = run_seeds(scenario, seeds(7, 3, 3));
  ASSERT_EQ(in_turn.size(), 3u);
  ASSERT_EQ(side_by_side.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_TRUE(is_the_same(in_turn[k], side_by_side[k])) << in_turn[k].seed;
  EXPECT_NE(in_turn[0].sent, in_turn[1].sent) << "another seed is another run";
  const auto again = run_seeds(scenario, seeds(9, 1));
  ASSERT_EQ(again.size(), 1u);
  EXPECT_TRUE(is_the_same(again[0], in_turn[2])) << "as the printed command repeats it";
}

TEST(FaultCampaign, ASeedWithoutAResultIsMissed) {
  const FaultScenario scenario = all_faults();
  RunResult run;
  run.blocks = 1;
  run.deaths_at_call = 2;
  run.disk_fulls = 1;
  run.longest_to_durable_s = scenario.slow_sync.shortest_s;
  EXPECT_EQ(summarise(scenario, {run, run}, seeds(1, 2)).missed, "");
  EXPECT_EQ(summarise(scenario, {run, run}, seeds(1, 3)).missed,
            "of 3 seeds 2 have a result: a process that ran them is gone");
}

TEST(FaultCampaign, AFaultThatDoesNotComeProvesNothing) {
  const FaultScenario scenario = all_faults();
  RunResult run;
  run.blocks = 1;
  run.deaths_at_call = 2;
  run.longest_to_durable_s = scenario.slow_sync.shortest_s;
  EXPECT_EQ(summarise(scenario, {run}, seeds(1, 1)).missed, "no recorder waited for space on its disk");
  run.disk_fulls = 1;
  run.longest_to_durable_s = 0;
  EXPECT_EQ(summarise(scenario, {run}, seeds(1, 1)).missed, "no sync was slow");
}

TEST(FaultCampaign, OnlyAShortRunOfWhatIsAskedForMaySealNothingAndNotEveryOne) {
  FaultScenario scenario;
  RunResult nothing, something;
  something.blocks = 1;
  EXPECT_EQ(summarise(scenario, {nothing, something}, seeds(1, 2)).failed.size(), 1u);
  scenario.vehicle = "vehicle.toml";
  Summary summary = summarise(scenario, {nothing, something}, seeds(1, 2));
  EXPECT_TRUE(summary.failed.empty());
  EXPECT_EQ(summary.missed, "");
  summary = summarise(scenario, {nothing, nothing}, seeds(1, 2));
  EXPECT_EQ(summary.missed, "nothing was sealed");
  CampaignOptions whole = seeds(1, 2);
  whole.seconds.reset();
  EXPECT_EQ(summarise(scenario, {nothing, something}, whole).failed.size(), 1u);
  scenario.least_seconds = scenario.seconds;  // asked for less, it is whole all the same
  EXPECT_EQ(summarise(scenario, {nothing, something}, seeds(1, 2)).failed.size(), 1u);
}

}  // namespace
}  // namespace roadbalance::test
