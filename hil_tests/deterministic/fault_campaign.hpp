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
  double least_blocks_per_s = 0;  ///< of one core
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
  std::string missed;                ///< what all of them together did not reach; empty: nothing

  bool good() const { return failed.empty() && missed.empty(); }
  /// Blocks a second of one core.
  double blocks_per_s() const {
    return all.processor_s > 0 ? static_cast<double>(all.blocks) / all.processor_s : 0;
  }
};
Summary summarise(const FaultScenario& scenario, const std::vector<RunResult>& results,
                  const CampaignOptions& options);

/// One line for people.
std::string line_of(const Summary& summary);

}  // namespace roadbalance::test
