#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hil_tests/deterministic/fault_scenario.hpp"
#include "hil_tests/deterministic/run_result.hpp"

namespace roadbalance::test {

struct CampaignOptions {
  std::uint64_t first_seed = 1;
  std::int64_t seeds = 20;
  int jobs = 1;
  std::optional<double> seconds;  ///< of production instead of the scenario's own, but no less than it needs
  std::string dump;               ///< folder; empty: none
};

/// All runs of one scenario, in order of seed.
std::vector<RunResult> run_seeds(const FaultScenario& scenario, const CampaignOptions& options);

/// The worst and the sums of many runs.
struct Summary {
  std::string scenario;
  std::int64_t runs = 0;
  RunResult all;                     ///< sums; longest of what is a longest
  double worst_sends_per_block = 0;  ///< of the runs
  std::vector<RunResult> failed;     ///< broke a promise, or did not reach what the scenario expects
};
Summary summarise(const FaultScenario& scenario, const std::vector<RunResult>& results);

/// One line for people.
std::string line_of(const Summary& summary);

}  // namespace roadbalance::test
