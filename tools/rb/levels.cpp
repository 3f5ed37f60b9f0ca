#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "common/text/format.hpp"
#include "host/recording/read_recording.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/reading_progress.hpp"
#include "tools/views/record_levels.hpp"
#include "tools/views/recording_defects.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct LevelsOptions {
  std::string folder;
  bool json = false;
};

void print_speeds(const Json& result) {
  if (result["wheels"].empty()) return;
  std::printf("%-24s %10s %10s %10s   slip against the mean; drift: arc between two wheels' angles\n",
              "wheel", "seconds", "turns", "slip %");
  for (const Json& wheel : result["wheels"]) {
    std::printf("%-24s %10.1f %10.1f %10s  ", wheel["wheel"].get<std::string>().c_str(),
                wheel["seconds"].get<double>(), wheel["turns"].get<double>(),
                wheel["slip"].is_null() ? "-" : format("%+.3f", 100.0 * wheel["slip"].get<double>()).c_str());
    for (const auto& [other, drift] : wheel["drift_deg"].items())
      if (!drift.is_null()) std::printf(" %s %.0f°", other.c_str(), drift.get<double>());
    std::printf("\n");
  }
  std::printf("%-24s %10s\n", "speed, km/h", "seconds");
  for (const Json& one : result["speed_classes"])
    std::printf("%-24s %10.1f\n",
                format("%.1f .. %.1f", 3.6 * one["from_m_s"].get<double>(), 3.6 * one["to_m_s"].get<double>())
                    .c_str(),
                one["seconds"].get<double>());
}

Json levels_of(const std::string& folder) {
  RecordLevels levels;
  std::optional<ReadingProgress> progress(std::in_place, folder, 1);
  const RecordingDefects defects = read_recording(
      folder, [&](const VehicleConfig& vehicle) { levels.begin(vehicle); },
      [&](const SealedBlock& block) { levels.consume(block); },
      [&](const ClockFit& fit) { levels.consume(fit); });
  progress.reset();
  warn_of_defects("levels", folder, defects);
  return levels.json();
}

std::string for_how_long(const char* what, const Json& seconds) {
  return seconds > 0.0 ? format("   %s %.1f s", what, seconds.get<double>()) : "";
}

int levels(const LevelsOptions& options) {
  const Json result = levels_of(options.folder);
  if (options.json) {
    std::printf("%s\n", result.dump().c_str());
  } else {
    std::printf("%-24s %10s %10s %10s   m/s^2; rms and peak about the mean\n", "channel", "mean", "rms",
                "peak");
    for (const auto& channel : result["channels"])
      std::printf("%-24s %10.3f %10.3f %10.3f%s%s%s%s\n", channel["channel"].get<std::string>().c_str(),
                  channel["mean"].get<double>(), channel["rms"].get<double>(), channel["peak"].get<double>(),
                  channel["overload"].get<bool>() ? "   OVERLOAD" : "",
                  for_how_long("CLIPPED", channel["clipped_s"]).c_str(),
                  for_how_long("DEAD", channel["dead_s"]).c_str(),
                  for_how_long("DC OFFSET", channel["dc_offset_s"]).c_str());
    print_speeds(result);
  }
  return result["channels"].empty() ? kAnswerIsNo : kDone;
}

}  // namespace

void add_levels(CLI::App& app, int& code) {
  auto options = std::make_shared<LevelsOptions>();
  CLI::App* command = app.add_subcommand(
      "levels",
      "Mean, rms and peak of every channel of a recording, clipped and dead channels and offsets; slip and "
      "drift of the wheels, how long each speed was driven");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = levels(*options); });
}

}  // namespace roadbalance
