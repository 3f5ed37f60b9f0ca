#include "tools/rb/identify.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/config/section.hpp"
#include "common/process/in_order.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/analysis/drives/many_recordings.hpp"
#include "host/recording/recordings_given.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/other_program.hpp"
#include "tools/rb/progress_line.hpp"
#include "tools/rb/reading_progress.hpp"
#include "tools/views/compensation_json.hpp"
#include "tools/views/identification_json.hpp"
#include "tools/views/overall_lines.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/recording_defects.hpp"
#include "tools/views/wheels_json.hpp"

namespace roadbalance {

namespace fs = std::filesystem;

namespace {

struct IdentifyOptions {
  std::vector<std::string> folders;
  std::size_t jobs = 1;
  bool skip_unusable = false;
  std::string estimator;
  bool json = false;
  bool refine = false;
  bool overall = false;
};

/// The estimate that many recordings give together.
struct TogetherTold {
  RecordedEstimate found;
  std::vector<ManyRecordings::Used> used;
  std::vector<ManyRecordings::LeftOut> left_out;
};

/// On `work.jobs` threads.
void share_on_threads(const std::vector<fs::path>& recordings, const ShareWork& work,
                      const std::function<void(std::size_t which, DriveShare share)>& take) {
  std::vector<std::size_t> which(recordings.size());
  std::iota(which.begin(), which.end(), std::size_t{0});
  in_order<DriveShare>(
      which, work.jobs, work.stop,
      [&](std::size_t i, const std::stop_token& stop) { return share_of(recordings[i], work.refine, stop); },
      take);
}

/// @throws as ManyRecordings; Interrupted
TogetherTold identify_together(const std::vector<fs::path>& recordings, bool skip_unusable,
                               const ShareWork& work, const DriveSharer& sharer) {
  ManyRecordings many(recordings, skip_unusable);
  std::vector<std::uint64_t> bytes;
  for (const fs::path& recording : many.recordings()) bytes.push_back(bytes_of_recording(recording));
  const auto all = static_cast<double>(std::accumulate(bytes.begin(), bytes.end(), std::uint64_t{0}));
  {
    ProgressLine line;
    std::uint64_t done = 0;
    sharer(many.recordings(), work, [&](std::size_t which, DriveShare share) {
      many.take(many.recordings()[which], std::move(share));
      done += bytes[which];
      line.show(all > 0.0 ? static_cast<double>(done) / all : 1.0, done);
    });
  }
  RecordedEstimate found = many.estimate();
  return {std::move(found), many.used(), many.left_out()};
}

/// {"recordings": [{"name", "seconds", "sections", "missing_blocks"}], "left_out": [{"name", "why"}]}
nlohmann::ordered_json together_json(const TogetherTold& told) {
  auto used = nlohmann::ordered_json::array(), left_out = nlohmann::ordered_json::array();
  for (const ManyRecordings::Used& one : told.used)
    used.push_back({{"name", one.recording.filename().string()},
                    {"seconds", one.seconds},
                    {"sections", one.sections},
                    {"missing_blocks", one.missing_blocks}});
  for (const ManyRecordings::LeftOut& one : told.left_out)
    left_out.push_back({{"name", one.recording.filename().string()}, {"why", one.why}});
  return {{"recordings", used}, {"left_out", left_out}};
}

/// @param recordings  what many recordings have to say of themselves, null: it is a single one
int tell(const IdentifyOptions& options, const RecordedEstimate& found,
         const nlohmann::ordered_json& recordings) {
  const auto& [identification, balance] = found.estimate;
  if (!found.refusal.empty()) std::fprintf(stderr, "rb identify: %s\n", found.refusal.c_str());
  if (options.overall && !found.overall)
    std::fprintf(stderr, "rb identify: no overall compensation: what turns with the wheels is not known\n");
  if (options.json) {
    nlohmann::ordered_json result{{"wheels", wheels_json(identification, balance)},
                                  {"suspension", suspension_json(identification)}};
    result["speeds"] = speeds_json(identification);
    result["compensation"] = compensation_json(balance, found.compensation);
    result["remarks"] = found.diagnostics;
    if (options.overall)
      result["overall"] = found.overall ? overall_json(*found.overall) : nlohmann::ordered_json();
    if (!recordings.is_null()) result.update(recordings);
    std::printf("%s\n", result.dump().c_str());
  } else {
    std::printf("%s\n", identification_line(identification, found.refusal).c_str());
    for (const std::string& line : suspension_lines(identification)) std::printf("  %s\n", line.c_str());
    for (std::size_t w = 0; w < kWheels; ++w) {
      std::printf("%s\n", balance_line(balance[w]).c_str());
      for (const std::string& line : advice_lines(balance[w], found.compensation[w]))
        std::printf("%s\n", line.c_str());
    }
    if (options.overall && found.overall)
      for (const std::string& line : overall_lines(*found.overall)) std::printf("%s\n", line.c_str());
    for (const std::string& remark : found.diagnostics) std::printf("  %s\n", remark.c_str());
  }
  const bool any =
      std::ranges::any_of(balance, [](const Balance& wheel) { return wheel.state == Unknown::kNone; });
  return any && (found.overall || !options.overall) ? kDone : kAnswerIsNo;
}

int identify_one(const IdentifyOptions& options, const std::stop_token& stop) {
  const std::string& folder = options.folders.front();
  const RecordedEstimate found = [&] {
    const ReadingProgress progress(folder, options.refine ? 3 : 1);
    return identify_record(folder, options.refine, stop);
  }();
  warn_of_defects("identify", folder, found.defects);
  return tell(options, found, nullptr);
}

int identify_all(const IdentifyOptions& options, const std::vector<fs::path>& recordings,
                 const ShareWork& work, const DriveSharer& sharer) try {
  const TogetherTold told = identify_together(recordings, options.skip_unusable, work, sharer);
  double seconds = 0.0;
  for (const auto& one : told.used) {
    seconds += one.seconds;
    if (one.missing_blocks > 0)
      std::fprintf(stderr, "rb identify: %s: %lld blocks are missing; the result is from the rest\n",
                   one.recording.c_str(), static_cast<long long>(one.missing_blocks));
  }
  for (const auto& one : told.left_out)
    std::fprintf(stderr, "rb identify: left out %s: %s\n", one.recording.c_str(), one.why.c_str());
  if (!options.json)
    std::printf("%zu recordings together, %.0f s of steady driving\n", told.used.size(), seconds);
  return tell(options, told.found, together_json(told));
} catch (const Unusable& error) {
  std::fprintf(stderr, "rb identify: %s\n", error.what());
  return kAnswerIsNo;
}

/// Whether a single one is given, and not a folder of recordings.
bool is_one(const std::vector<std::string>& folders, const std::vector<fs::path>& recordings) {
  return folders.size() == 1 && recordings.size() == 1 &&
         recordings.front() == fs::canonical(folders.front());
}

int identify_by_estimator(const IdentifyOptions& options, const EstimatorCall& call) {
  const auto recordings = recordings_given(options.folders);
  if (!is_one(options.folders, recordings))
    throw ConfigError("--estimator takes one recording, not " + std::to_string(recordings.size()));
  return call(options.estimator, options.folders.front(), options.refine, options.json);
}

/// In a process that prints the result.
int identify(const IdentifyOptions& options, const ShareWork& work, const DriveSharer& sharer) {
  bool shared = false;
  const DriveSharer once = [&](const auto& recordings, const ShareWork& how, const auto& take) {
    shared = true;
    sharer(recordings, how, take);
  };
  // Whoever else works on it must not wait for what does not come.
  const auto nothing_to_share = [&] {
    if (!std::exchange(shared, true)) sharer({}, work, {});
  };
  try {
    const auto recordings = recordings_given(options.folders);
    const bool one = is_one(options.folders, recordings);
    if (one) nothing_to_share();
    return one ? identify_one(options, work.stop) : identify_all(options, recordings, work, once);
  } catch (...) {
    nothing_to_share();
    throw;
  }
}

}  // namespace

void add_identify_over(CLI::App& app, int& code, const IdentifyWays& ways) {
  auto options = std::make_shared<IdentifyOptions>();
  options->jobs = ways.jobs;
  CLI::App* command = app.add_subcommand(
      "identify",
      "Finds tyre stiffness and unbalance of every wheel from a recording, or from many of one car");
  command
      ->add_option("folders", options->folders,
                   "the recording; several, or a folder of recordings, are drives of one car and give one "
                   "estimate")
      ->required();
  command
      ->add_option("--jobs", options->jobs, "recordings read at a time; the result is the same bit for bit")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_flag("--skip-unusable", options->skip_unusable,
                    "leave out, and name, recordings that are damaged, too short or cannot be read; else "
                    "one of many is an error");
  command->add_option(
      "--estimator", options->estimator,
      "put the drive to one estimator instead of the product's chain; rb-study identify --help "
      "names them");
  command
      ->add_flag(
          "--overall", options->overall,
          "also weights that make the vertical vibration at every [[seat]] of vehicle.toml least over all "
          "speeds driven, whatever turns with the wheels")
      ->excludes("--estimator");
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->add_flag(
      "--refine", options->refine,
      "compute the relations of the nodes' clocks and the wheels' angles again from all recorded "
      "exchanges and edges, which are in memory at once: up to 100 bytes an edge, 1.4 GB for an hour of "
      "four rings of 96 at 18 turns a second");
  command->footer(
      "Recordings of another car, or with other weights, zero marks or sensor places by their vehicle.toml, "
      "are refused, naming the key and both.\n"
      "Exit codes: 0 done, 1 no wheel is identified or a recording is unusable, 2 usage or another car, "
      "4 cannot read.");
  command->callback([options, &code, ways] {
    if (!options->estimator.empty()) {
      if (ways.speaks) code = identify_by_estimator(*options, ways.estimate);
      return;
    }
    const StopOnSignal signals;
    const ShareWork work{options->jobs, options->refine, signals.token()};
    if (ways.speaks)
      code = identify(*options, work, ways.sharer);
    else
      ways.sharer({}, work, {});
  });
}

void add_identify(CLI::App& app, int& code) {
  const auto estimate = [](const std::string& estimator, const std::string& folder, bool refine,
                           bool json) -> int {
    std::vector<std::string> words{"identify", "--estimator", estimator};
    if (refine) words.emplace_back("--refine");
    if (json) words.emplace_back("--json");
    words.insert(words.end(), {"--", folder});
    become_program("study", words);
  };
  add_identify_over(app, code,
                    {.sharer = share_on_threads,
                     .estimate = estimate,
                     .jobs = std::max(1U, std::thread::hardware_concurrency()),
                     .speaks = true});
}

}  // namespace roadbalance
