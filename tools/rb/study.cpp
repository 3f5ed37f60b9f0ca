#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>

#include "common/bus/bus.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/quiet_port.hpp"
#include "tools/rb/study_encoder.hpp"
#include "tools/rb/temporary_folder.hpp"
#include "tools/study/campaign.hpp"
#include "tools/study/clock_skew.hpp"
#include "tools/study/demo_accuracy.hpp"
#include "tools/study/drift_cost.hpp"

namespace roadbalance {
namespace {

struct StudyOptions {
  std::string name;
  int runs = 20;
  std::uint64_t seed = 1;
  std::string state;
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  double drive_seconds = 320.0;
  double seconds = 30.0;
  int nodes = 4;
  bool json = false;
};

void print_line(const nlohmann::ordered_json& line) {
  const std::string error =
      line.contains("standard_error") ? " +- " + line["standard_error"].dump().substr(0, 6) : "";
  std::printf("%s  %-72s %8s%s  (%g .. %g)\n", line["met"].get<bool>() ? "met    " : "NOT MET",
              line["line"].get<std::string>().c_str(), line["value"].dump().substr(0, 8).c_str(),
              error.c_str(), line["required"][0].get<double>(), line["required"][1].get<double>());
}

/// @param percent, degrees  keys of a wheel in summary["seeds"]
void print(const nlohmann::ordered_json& summary, const char* percent, const char* degrees) {
  for (const auto& run : summary["seeds"]) {
    std::printf("seed %5llu", static_cast<unsigned long long>(run["seed"].get<std::uint64_t>()));
    if (run.contains("good")) std::printf(" %s", run["good"].get<bool>() ? "good" : "BAD ");
    for (const auto& wheel : run["wheels"])
      if (!wheel[degrees].is_number() || !std::isfinite(wheel[degrees].get<double>()))
        std::printf("  %s unknown", wheel["name"].get<std::string>().c_str());
      else
        std::printf("  %s %6.2f %% %6.2f°", wheel["name"].get<std::string>().c_str(),
                    wheel[percent].get<double>(), wheel[degrees].get<double>());
    std::printf("\n");
  }
  for (const auto& line : summary["acceptance"]) print_line(line);
}

int study_clock_skew(const StudyOptions& options) {
  const TemporaryFolder record("rb-clock-skew");
  const nlohmann::ordered_json result = clock_skew({.bus_url = bus_url_on_port(quiet_port(0)),
                                                    .folder = record.path(),
                                                    .seconds = options.seconds,
                                                    .nodes = options.nodes});
  if (options.json) {
    std::printf("%s\n", result.dump().c_str());
  } else {
    const auto number = [&](const char* key) { return result[key].get<double>(); };
    std::printf("skew between %d nodes over %.0f s: p50 %.1f us, p99 %.1f us, largest %.1f us\n",
                options.nodes, options.seconds, number("skew_p50_us"), number("skew_p99_us"),
                number("skew_max_us"));
    std::printf("stated uncertainty (median %.1f us) covers %.2f %% of %d windows; %.1f %% kernel stamps\n",
                number("uncertainty_p50_us"), number("covered_percent"), result["windows"].get<int>(),
                number("kernel_stamps_percent"));
    std::printf("%s  skew p99 at most 50 us and 99.9 %% of the windows covered\n",
                result["met"].get<bool>() ? "met    " : "NOT MET");
  }
  return result["met"].get<bool>() ? kDone : kAnswerIsNo;
}

int study(const StudyOptions& options) {
  if (options.name == "clock-skew") return study_clock_skew(options);
  std::unique_ptr<TemporaryFolder> temporary;
  if (options.state.empty()) temporary = std::make_unique<TemporaryFolder>("rb-study");
  const std::filesystem::path folder = temporary ? temporary->path().string() : options.state;
  const bool drifts = options.name == "drift";
  const Campaign campaign{options.name,
                          drifts ? nlohmann::ordered_json::object()
                                 : nlohmann::ordered_json{{"drive_seconds", options.drive_seconds}},
                          options.runs,
                          options.seed,
                          folder,
                          options.jobs};
  const auto runs = run_campaign(campaign, [&](std::uint64_t seed) {
    return drifts ? drift_cost_run(seed, folder) : demo_accuracy_run(seed, options.drive_seconds);
  });
  nlohmann::ordered_json summary = drifts ? drift_cost_summary(runs) : demo_accuracy_summary(runs);
  if (options.json) {
    if (!drifts) summary["results"] = runs;
    std::printf("%s\n", summary.dump().c_str());
  } else if (drifts) {
    print(summary, "change_percent", "change_deg");
  } else {
    print(summary, "error_percent", "error_deg");
  }
  return summary["accepted"].get<bool>() ? kDone : kAnswerIsNo;
}

/// What was asked for and would not be done.
void refuse_options_of_others(const CLI::App& command, const std::string& name) {
  static const std::map<std::string, std::set<std::string>> kOfStudy{
      {"--runs", {"demo-accuracy", "drift", "encoder"}},
      {"--seed", {"demo-accuracy", "drift", "encoder"}},
      {"--state", {"demo-accuracy", "drift"}},
      {"--jobs", {"demo-accuracy", "drift"}},
      {"--drive-seconds", {"demo-accuracy"}},
      {"--seconds", {"clock-skew"}},
      {"--nodes", {"clock-skew"}}};
  for (const auto& [option, studies] : kOfStudy)
    if (command.count(option) > 0 && !studies.contains(name))
      throw ConfigError(option + ": is not of study " + name + "; allowed with " + *studies.begin());
}

}  // namespace

void add_study(CLI::App& app, int& code) {
  auto options = std::make_shared<StudyOptions>();
  CLI::App* command =
      app.add_subcommand("study", "Repeats an experiment over many seeds and says what came out");
  command
      ->add_option("name", options->name,
                   "demo-accuracy: the demo's estimates against the truth; drift: what a drift of "
                   "5 km/h a minute costs the identified unbalance; clock-skew: the fits of "
                   "running nodes' clocks against what they show; encoder: angles from pulse trains "
                   "against the truth")
      ->required()
      ->check(CLI::IsMember({"demo-accuracy", "drift", "clock-skew", "encoder"}));
  command->add_option("--runs", options->runs, "how many seeds; encoder: 1 unless said")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "the first seed; encoder: 11 unless said")
      ->check(seed_number())
      ->capture_default_str();
  command->add_option("--state", options->state,
                      "folder of results; a study found there goes on where it stopped");
  command->add_option("--jobs", options->jobs, "runs at a time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_option("--drive-seconds", options->drive_seconds, "length of each drive")
      ->check(drive_length())
      ->capture_default_str();
  command->add_option("--seconds", options->seconds, "how long clock-skew compares")
      ->check(number_within(1.0, 1e5))
      ->capture_default_str();
  command->add_option("--nodes", options->nodes, "how many nodes clock-skew runs")
      ->check(CLI::Range(2, 16))
      ->capture_default_str();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, command, &code] {
    refuse_options_of_others(*command, options->name);
    if (options->name != "encoder") {
      code = study(*options);
      return;
    }
    EncoderStudyOptions encoder;
    encoder.json = options->json;
    if (command->count("--runs") > 0) encoder.runs = options->runs;
    if (command->count("--seed") > 0) encoder.seed = options->seed;
    code = study_encoder(encoder);
  });
}

}  // namespace roadbalance
