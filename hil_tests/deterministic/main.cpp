#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "hil_tests/deterministic/fault_campaign.hpp"
#include "hil_tests/deterministic/planted_name.hpp"

namespace {

using namespace roadbalance;
using namespace roadbalance::test;

std::filesystem::path scenario_folder() {
  return RB_SCENARIOS;
}

/// Small ones first: "all" leaves out the long drives, which are asked for by name.
std::vector<std::string> scenario_files(const std::vector<std::string>& asked) {
  std::vector<std::string> files;
  for (const std::string& name : asked) {
    if (name != "all") {
      files.push_back(std::filesystem::exists(name) ? name : (scenario_folder() / (name + ".toml")).string());
      continue;
    }
    for (const auto& entry : std::filesystem::directory_iterator(scenario_folder()))
      if (entry.path().extension() == ".toml" && !entry.path().stem().string().starts_with("long_"))
        files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string command_of(std::uint64_t seed, const std::string& scenario, const CampaignOptions& options,
                       const std::string& program) {
  std::string command = program + " --scenario " + scenario + " --seeds 1 --first " + std::to_string(seed);
  if (options.seconds) command += " --seconds " + std::to_string(*options.seconds);
#ifdef RB_PLANTED_FAULTS
  command += plant_option(planted_fault);
#endif
  return command;
}

bool run(const std::string& file, const CampaignOptions& options, const std::string& program) {
  const FaultScenario scenario = FaultScenario::read_file(file);
  const Summary summary = summarise(scenario, run_seeds(scenario, options), options);
  std::printf("%s%s\n", line_of(summary).c_str(), summary.good() ? "" : "  FAILED");
  if (!summary.missed.empty()) std::printf("  %s\n", summary.missed.c_str());
  for (const RunResult& run : summary.failed) {
    std::printf("  seed %llu: %lld promises broken\n", static_cast<unsigned long long>(run.seed),
                static_cast<long long>(run.faults));
    for (std::string what = run.what.data(); !what.empty();) {
      const auto end = std::min(what.find('\n'), what.size());
      std::printf("    %s\n", what.substr(0, end).c_str());
      what.erase(0, end + 1);
    }
    std::printf("  again: %s\n", command_of(run.seed, file, options, program).c_str());
  }
  std::fflush(stdout);
  return summary.good();
}

#ifdef RB_PLANTED_FAULTS
void add_plant(CLI::App& app) {
  app.add_option_function<std::string>(
      "--plant",
      [](const std::string& name) {
        const auto fault = planted_named(name);
        if (!fault)
          throw CLI::ValidationError("--plant",
                                     name + " is no planted fault; there are: " + all_planted_names());
        planted_fault = *fault;
      },
      "the fault that this build has");
}
#else
void add_plant(CLI::App&) {}
#endif

}  // namespace

int main(int argc, char** argv) {
  // Memory of one run serves the next: fresh pages would cost more than the run.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  CLI::App app("rb-faults: the product's own link, recorder and record under faults, one run for each seed");
  CampaignOptions options;
  std::vector<std::string> asked{"all"};
  double seconds = 0;
  app.add_option(
      "--scenario", asked,
      "file, or name of one in hil_tests/deterministic/scenarios; all: every one but the long drives");
  app.add_option("--seeds", options.seeds, "runs of each scenario")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--first", options.first_seed, "the first seed")->capture_default_str();
  app.add_option("--jobs", options.jobs, "processes side by side")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--seconds", seconds, "of production instead of what the scenario says")
      ->check(CLI::Range(0.1, 1e7));
  app.add_option("--least-blocks-per-s", options.least_blocks_per_s,
                 "that one core must reach in each scenario, or the exit code is 1");
  app.add_option("--dump", options.dump, "write the last run's record and truth.json into this folder");
  add_plant(app);
  try {
    app.parse(argc, argv);
    if (seconds > 0) options.seconds = seconds;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    bool good = true;
    for (const std::string& file : scenario_files(asked)) good = run(file, options, argv[0]) && good;
    return good ? 0 : 1;
  } catch (const ConfigError& error) {
    std::fprintf(stderr, "rb-faults: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb-faults: %s\n", error.what());
    return 4;
  }
}
