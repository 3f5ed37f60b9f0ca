#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace roadbalance {

/// Many runs of one experiment, each with its own seed, side by side on all cores.
struct Campaign {
  std::string name;                 ///< goes into the names of result files
  nlohmann::ordered_json settings;  ///< what, beside the seed, decides a run's result
  int runs = 1;
  std::uint64_t first_seed = 1;
  std::filesystem::path state;  ///< folder for one result file a run
  int jobs = 1;                 ///< runs at a time
  bool in_process = false;      ///< one after another, without processes of their own; `jobs` is not used
};

/// One run.  It is called in a process of its own, unless Campaign::in_process.
using Experiment = std::function<nlohmann::ordered_json(std::uint64_t seed)>;

/// Results in order of seed.  Progress goes to standard error.
///
/// A run whose result file is in `state`, made with the same settings by the same build, is not done again;
/// so an interrupted campaign goes on where it stopped.
/// @throws std::runtime_error naming the seed if a run fails, std::system_error if `state` cannot be written
std::vector<nlohmann::ordered_json> run_campaign(const Campaign& campaign, const Experiment& experiment);

/// The same of these seeds only, instead of campaign.runs from campaign.first_seed on, in their order.
std::vector<nlohmann::ordered_json> run_seeds(const Campaign& campaign,
                                              const std::vector<std::uint64_t>& seeds,
                                              const Experiment& experiment);

}  // namespace roadbalance
