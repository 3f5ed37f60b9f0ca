#include "tools/study/study_command.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/quiet_port.hpp"
#include "common/command_line/exit_code.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "common/process/temporary_folder.hpp"
#include "tools/study/clock_skew.hpp"
#include "tools/study/encoder_study.hpp"
#include "tools/study/phase_injection.hpp"
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

/// For studies that report each seed: a wheel's "error_percent" and "error_deg", or "change_...".
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

/// "30 runs; --set samples=50000 estimators=": the values that hold unless given.
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

/// `rb-study clock-skew`: clock_skew() on a bus of its own; prints what came out or, with `json`, its object
/// on one line.  Exit code kAnswerIsNo if the skew is larger than asked.
int study_clock_skew(const StudyOptions& options) {
  const TemporaryFolder record("rb-clock-skew");
  const Json result = clock_skew({.bus_url = bus_url_on_port(quiet_port(0)),
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

struct EncoderStudyOptions {
  bool json = false, markdown = false;
  int runs = 1;                       ///< of each row, with other noise
  std::optional<std::uint64_t> seed;  ///< of the first run; unset: the rows' own
};

void print_angle_errors(const Json& row, const std::string& prefix) {
  const std::string rms = prefix + "rms_deg", max = prefix + "max_deg";
  if (!row.contains(rms)) return;
  if (row[max].is_null())
    std::printf("  %.4f /   any ", row[rms].get<double>());
  else
    std::printf("  %.4f / %.4f", row[rms].get<double>(), row[max].get<double>());
}

void print_encoder_runs(const Json& row) {
  const int runs = row["runs"].get<int>();
  std::printf("  worst run %.4f", row["worst_run_rms_deg"].get<double>());
  if (const int met = row["runs_met"].get<int>(); met < runs)
    std::printf(", met by %d of %d runs, by %d but for what their zero marks are off", met, runs,
                row["runs_met_but_for_marks"].get<int>());
}

void print_encoder_row(const Json& row) {
  std::printf("%s %-68s", row["met"].get<bool>() ? "met    " : "NOT MET",
              row["case"].get<std::string>().c_str());
  for (const char* const prefix : {"allowed_", "", "offline_"}) print_angle_errors(row, prefix);
  if (const int unknown = row["unknown_blocks"].get<int>(); unknown > 0)
    std::printf("  %d blocks without an angle", unknown);
  if (row.value("runs", 1) > 1) print_encoder_runs(row);
  std::printf("\n");
  std::fflush(stdout);
}

/// `rb-study encoder`: every pulse train of encoder_rows() through the live encoder and the offline one, and
/// phases injected into the chain from edges and conversions to blocks (phase_injection_rows()); prints a
/// table, with `markdown` one in Markdown or, with `json`, {"rows": [...], "met"} on one line.  Exit code
/// kAnswerIsNo if a row is not met.
int study_encoder(const EncoderStudyOptions& options) {
  Json rows = Json::array();
  bool met = true;
  const auto add = [&](const Json& row) {
    met = met && row["met"].get<bool>();
    if (!options.json && !options.markdown) print_encoder_row(row);
    rows.push_back(row);
  };
  if (!options.json && !options.markdown)
    std::printf("        %-68s %17s %17s %17s\n", "angle error in degrees, rms / max", "allowed", "live",
                "offline");
  for (EncoderRow& row : encoder_rows()) {
    if (options.seed) row.train.seed = *options.seed;
    add(encoder_row_result(row, options.runs));
  }
  for (const auto& row : phase_injection_rows()) add(row);
  if (options.json) std::printf("%s\n", Json{{"rows", rows}, {"met", met}}.dump().c_str());
  if (options.markdown)
    std::printf(
        "%s",
        markdown_tables(Json{{"tables", {{{"title", "Angle errors, degrees"}, {"rows", rows}}}}}).c_str());
  return met ? kDone : kAnswerIsNo;
}

/// Options that the study would ignore.
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
  if (study.name == "clock-skew") return study_clock_skew(options);
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

void add_study(CLI::App& command, int& code, const Campaigner& campaigner, int jobs, bool speaks) {
  auto options = std::make_shared<StudyOptions>();
  options->jobs = jobs;
  command.add_option("name", options->name, "list: says which studies there are and what they are of");
  command.add_option("--runs", options->runs, "how many seeds, instead of the study's own number")
      ->check(CLI::Range(1, 1'000'000));
  command.add_option("--seed", options->seed, "the first seed")->check(seed_number());
  command.add_option("--state", options->state,
                     "folder of results; a study found there goes on where it stopped");
  command.add_option("--jobs", options->jobs, "runs at a time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command.add_option("--set", options->settings, "KEY=VALUE: another value for one of the study's settings");
  command.add_option("--svg", options->svg, "folder for the study's figures");
  command.add_flag("--markdown", options->markdown, "tables as Markdown");
  command.add_option("--drive-seconds", options->drive_seconds, "length of each drive")
      ->check(drive_length())
      ->capture_default_str();
  command.add_option("--seconds", options->seconds, "how long clock-skew compares")
      ->check(number_within(1.0, 1e5))
      ->capture_default_str();
  command.add_option("--nodes", options->nodes, "how many nodes clock-skew runs")
      ->check(CLI::Range(2, 16))
      ->capture_default_str();
  command.add_flag("--json", options->json, "one JSON object on standard output");
  command.callback([options, &command, campaigner, speaks, &code] {
    if (!command.get_subcommands().empty()) return;  // another command than a study
    if (options->name.empty()) throw CLI::RequiredError("name");
    code = study(command, *options, campaigner, speaks);
  });
}

}  // namespace roadbalance
