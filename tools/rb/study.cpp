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
#include "common/process/temporary_folder.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/study_clock_skew.hpp"
#include "tools/rb/study_encoder.hpp"
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
  std::printf("%s%s", plain_tables(summary).c_str(), plain_acceptance(summary).c_str());
}

/// "30 runs; --set samples=50000 estimators=": what there is unless said.
std::string defaults_of(const Study& study) {
  const auto takes = [&](const char* option) { return std::ranges::count(study.options, option) > 0; };
  std::string text;
  if (takes("--runs")) text = std::to_string(study.runs) + (study.runs == 1 ? " run" : " runs");
  if (takes("--set") && !study.settings.empty()) {
    text += (text.empty() ? "" : "; ") + std::string("--set");
    for (const auto& [key, value] : study.settings.items()) {
      std::string shown = value.is_string() ? value.get<std::string>() : value.dump();
      if (value.is_array()) shown = shown.substr(1, shown.size() - 2);
      text += " " + key + "=" + shown;
    }
  }
  return text;
}

int list_studies(bool json) {
  Json all = Json::array();
  for (const Study& study : studies())
    if (json) {
      all.push_back({{"name", study.name},
                     {"line", study.line},
                     {"options", study.options},
                     {"runs", study.runs},
                     {"settings", study.settings}});
    } else {
      std::printf("%-14s %s\n", study.name.c_str(), study.line.c_str());
      if (const std::string text = defaults_of(study); !text.empty())
        std::printf("%-14s %s\n", "", text.c_str());
    }
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
    std::string others;
    for (const Study& other : studies())
      if (takes(other)) others += (others.empty() ? "" : ", ") + other.name;
    throw ConfigError(name + ": is not of study " + study.name + "; allowed with " + others);
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
    encoder.markdown = options.markdown;
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
