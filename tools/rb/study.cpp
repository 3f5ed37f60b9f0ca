#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "tools/rb/command.hpp"
#include "tools/rb/temporary_folder.hpp"
#include "tools/rb/validators.hpp"
#include "tools/study/campaign.hpp"
#include "tools/study/demo_accuracy.hpp"

namespace roadbalance {
namespace {

struct StudyOptions {
  std::string name;
  int runs = 20;
  std::uint64_t seed = 1;
  std::string state;
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  double drive_seconds = 320.0;
  bool json = false;
};

void print(const nlohmann::ordered_json& summary) {
  for (const auto& run : summary["seeds"]) {
    std::printf("seed %5llu %s", static_cast<unsigned long long>(run["seed"].get<std::uint64_t>()),
                run["good"].get<bool>() ? "good" : "BAD ");
    for (const auto& wheel : run["wheels"])
      if (wheel["error_deg"].is_null() || !std::isfinite(wheel["error_deg"].get<double>()))
        std::printf("  %s unknown", wheel["name"].get<std::string>().c_str());
      else
        std::printf("  %s %5.1f %% %5.1f°", wheel["name"].get<std::string>().c_str(),
                    wheel["error_percent"].get<double>(), wheel["error_deg"].get<double>());
    std::printf("\n");
  }
  for (const auto& line : summary["acceptance"])
    std::printf("%s  %-72s %8s  (%g .. %g)\n", line["met"].get<bool>() ? "met    " : "NOT MET",
                line["line"].get<std::string>().c_str(), line["value"].dump().substr(0, 8).c_str(),
                line["required"][0].get<double>(), line["required"][1].get<double>());
}

int study(const StudyOptions& options) {
  std::unique_ptr<TemporaryFolder> temporary;
  if (options.state.empty()) temporary = std::make_unique<TemporaryFolder>("rb-study");
  const Campaign campaign{options.name,
                          {{"drive_seconds", options.drive_seconds}},
                          options.runs,
                          options.seed,
                          temporary ? temporary->path().string() : options.state,
                          options.jobs};
  const auto runs = run_campaign(
      campaign, [&](std::uint64_t seed) { return demo_accuracy_run(seed, options.drive_seconds); });
  nlohmann::ordered_json summary = demo_accuracy_summary(runs);
  if (options.json) {
    summary["results"] = runs;
    std::printf("%s\n", summary.dump().c_str());
  } else {
    print(summary);
  }
  return summary["accepted"].get<bool>() ? kDone : kAnswerIsNo;
}

}  // namespace

void add_study(CLI::App& app, int& code) {
  auto options = std::make_shared<StudyOptions>();
  CLI::App* command =
      app.add_subcommand("study", "Repeats an experiment over many seeds and says what came out");
  command->add_option("name", options->name, "demo-accuracy: the demo's estimates against the truth")
      ->required()
      ->check(CLI::IsMember({"demo-accuracy"}));
  command->add_option("--runs", options->runs, "how many seeds")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "the first seed")->check(seed_number())->capture_default_str();
  command->add_option("--state", options->state,
                      "folder of results; a study found there goes on where it stopped");
  command->add_option("--jobs", options->jobs, "runs at a time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_option("--drive-seconds", options->drive_seconds, "length of each drive")
      ->check(drive_length())
      ->capture_default_str();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = study(*options); });
}

}  // namespace roadbalance
