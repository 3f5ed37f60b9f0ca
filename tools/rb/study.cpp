#include "tools/rb/study.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>

#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/study_clock_skew.hpp"
#include "tools/rb/study_encoder.hpp"
#include "common/process/temporary_folder.hpp"
#include "tools/study/study.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct StudyOptions {
  std::string name;
  int runs = 0;
  std::uint64_t seed = 0;
  std::string state;
  int jobs = 1;
  double drive_seconds = 320.0;
  double seconds = 30.0;
  int nodes = 4;
  std::vector<std::string> settings;
  std::string svg;
  bool json = false, markdown = false;
};

void print_line(const Json& line) {
  const std::string error =
      line.contains("standard_error") ? " +- " + line["standard_error"].dump().substr(0, 6) : "";
  const std::string answers = line.contains("answers") ? " of " + line["answers"].dump() + " answers" : "";
  std::printf("%s  %-72s %8s%s  (%g .. %g)%s\n", line["met"].get<bool>() ? "met    " : "NOT MET",
              line["line"].get<std::string>().c_str(), line["value"].dump().substr(0, 8).c_str(),
              error.c_str(), line["required"][0].get<double>(), line["required"][1].get<double>(),
              answers.c_str());
}

/// Of studies that tell each seed: a wheel's "error_percent" and "error_deg", or "change_...".
void print_seed(const Json& run) {
  std::printf("seed %5llu", static_cast<unsigned long long>(run["seed"].get<std::uint64_t>()));
  if (run.contains("good")) std::printf(" %s", run["good"].get<bool>() ? "good" : "BAD ");
  for (const Json& wheel : run["wheels"]) {
    const std::string what = wheel.contains("error_percent") ? "error" : "change";
    const Json &percent = wheel[what + "_percent"], &degrees = wheel[what + "_deg"];
    if (!degrees.is_number() || !std::isfinite(degrees.get<double>()))
      std::printf("  %s unknown", wheel["name"].get<std::string>().c_str());
    else
      std::printf("  %s %6.2f %% %6.2f°", wheel["name"].get<std::string>().c_str(), percent.get<double>(),
                  degrees.get<double>());
  }
  std::printf("\n");
}

void print(const Json& summary) {
  for (const Json& run : summary.value("seeds", Json::array())) print_seed(run);
  std::printf("%s", plain_tables(summary).c_str());
  const Json lines = summary.value("acceptance", Json());
  for (const Json& line : lines) print_line(line);
  if (lines.is_array() && lines.empty()) std::printf("NOT MET  nothing was judged\n");
}

int list_studies(bool json) {
  Json all = Json::array();
  for (const Study& study : studies())
    if (json)
      all.push_back({{"name", study.name}, {"line", study.line}});
    else
      std::printf("%-14s %s\n", study.name.c_str(), study.line.c_str());
  if (json) std::printf("%s\n", Json{{"studies", all}}.dump().c_str());
  return kDone;
}

Json settings_of(const Study& study, const CLI::App& command, const StudyOptions& options) {
  Json settings = study.settings;
  for (const std::string& change : options.settings) change_setting(settings, change);
  if (command.count("--drive-seconds") > 0) settings["drive_seconds"] = options.drive_seconds;
  return settings;
}

/// What was asked for and would not be done.
void refuse_options_of_others(const CLI::App& command, const Study& study) {
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (option->count() == 0 || !name.starts_with("--") || name == "--json") continue;
    const auto takes = [&](const Study& other) {
      return std::find(other.options.begin(), other.options.end(), name) != other.options.end();
    };
    if (takes(study)) continue;
    const auto other = std::find_if(studies().begin(), studies().end(), takes);
    throw ConfigError(name + ": is not of study " + study.name + "; allowed with " + other->name);
  }
}

int run_study(const Study& study, const CLI::App& command, const StudyOptions& options,
              const Campaigner& campaigner) {
  const Json settings = settings_of(study, command, options);
  std::vector<Json> runs;
  if (study.run != nullptr) {
    std::unique_ptr<TemporaryFolder> temporary;
    if (options.state.empty()) temporary = std::make_unique<TemporaryFolder>("rb-study");
    const std::filesystem::path folder = temporary ? temporary->path().string() : options.state;
    const Campaign campaign{study.name,
                            settings,
                            command.count("--runs") > 0 ? options.runs : study.runs,
                            command.count("--seed") > 0 ? options.seed : study.seed,
                            folder,
                            options.jobs};
    auto results = campaigner(campaign, [&](std::uint64_t seed) {
      return study.run({seed, settings, folder});
    });
    if (!results) return kDone;
    runs = std::move(*results);
  }
  const StudyResult result = study.summarise(settings, runs);
  if (!options.svg.empty()) write_figures(result.figures, options.svg);
  if (options.json)
    std::printf("%s\n", result.summary.dump().c_str());
  else if (options.markdown)
    std::printf("%s", markdown_tables(result.summary).c_str());
  else
    print(result.summary);
  return result.summary.value("accepted", true) ? kDone : kAnswerIsNo;
}

int study(const CLI::App& command, const StudyOptions& options, const Campaigner& campaigner, bool speaks) {
  if (options.name == "list") return speaks ? list_studies(options.json) : kDone;
  const Study& study = study_of(options.name);
  refuse_options_of_others(command, study);
  if (study.run == nullptr && !speaks) return kDone;
  if (study.name == "clock-skew")
    return study_clock_skew({.seconds = options.seconds, .nodes = options.nodes, .json = options.json});
  if (study.name == "encoder") {
    EncoderStudyOptions encoder;
    encoder.json = options.json;
    if (command.count("--runs") > 0) encoder.runs = options.runs;
    if (command.count("--seed") > 0) encoder.seed = options.seed;
    return study_encoder(encoder);
  }
  return run_study(study, command, options, campaigner);
}

}  // namespace

void add_study_over(CLI::App& app, int& code, const Campaigner& campaigner, int jobs, bool speaks) {
  auto options = std::make_shared<StudyOptions>();
  options->jobs = jobs;
  CLI::App* command =
      app.add_subcommand("study", "Repeats an experiment over many seeds and says what came out");
  command->add_option("name", options->name, "list: says which studies there are and what they are of")
      ->required();
  command->add_option("--runs", options->runs, "how many seeds, instead of the study's own number")
      ->check(CLI::Range(1, 1'000'000));
  command->add_option("--seed", options->seed, "the first seed")->check(seed_number());
  command->add_option("--state", options->state,
                      "folder of results; a study found there goes on where it stopped");
  command->add_option("--jobs", options->jobs, "runs at a time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_option("--set", options->settings, "KEY=VALUE: another value for one of the study's settings");
  command->add_option("--svg", options->svg, "folder for the study's figures");
  command->add_flag("--markdown", options->markdown, "tables as Markdown");
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
  command->callback([options, command, campaigner, speaks, &code] {
    code = study(*command, *options, campaigner, speaks);
  });
}

void add_study(CLI::App& app, int& code) {
  add_study_over(app, code, run_campaign, static_cast<int>(std::max(1U, std::thread::hardware_concurrency())),
                 true);
}

}  // namespace roadbalance
