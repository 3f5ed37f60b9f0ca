#include "hil_tests/deterministic/campaign.hpp"

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

// All that a run counts, and what it found; the processor's time is nobody's promise.
std::string told(RunResult run) {
  run.processor_s = 0;
  Summary summary;
  summary.all = run;
  return std::to_string(run.seed) + ": " + line_of(summary) + " sent " + std::to_string(run.sent) +
         " recorded " + std::to_string(run.recorded) + " scans " + std::to_string(run.scans) + " over at " +
         std::to_string(run.bus_s) + ", " + run.what.data();
}

TEST(FaultCampaign, OneSeedIsOneRunInWhicheverProcessAndBehindWhicheverOther) {
  const FaultScenario scenario = all_faults();
  const auto in_turn = run_seeds(scenario, seeds(7, 3));
  const auto side_by_side = run_seeds(scenario, seeds(7, 3, 3));
  ASSERT_EQ(in_turn.size(), 3u);
  ASSERT_EQ(side_by_side.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(told(in_turn[k]), told(side_by_side[k]));
  EXPECT_NE(in_turn[0].sent, in_turn[1].sent) << "another seed is another run";
  const auto again = run_seeds(scenario, seeds(9, 1));
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(told(again[0]), told(in_turn[2])) << "as the printed command repeats it";
}

TEST(FaultCampaign, ASeedWithoutAResultIsMissed) {
  const FaultScenario scenario = all_faults();
  RunResult run;
  run.blocks = 1;
  run.deaths_at_call = 2;
  EXPECT_EQ(summarise(scenario, {run, run}, seeds(1, 2)).missed, "");
  EXPECT_EQ(summarise(scenario, {run, run}, seeds(1, 3)).missed,
            "of 3 seeds 2 have a result: a process that ran them is gone");
}

}  // namespace
}  // namespace roadbalance::test
