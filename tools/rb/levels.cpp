#include "host/analyser/levels.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "common/bus/codec.hpp"
#include "host/analyser/read_recording.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/defects.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct LevelsOptions {
  std::string folder;
  bool json = false;
};

/// Levels of every channel over the whole recording.
Json levels_of(const std::string& folder) {
  VehicleConfig vehicle;
  std::map<std::int32_t, LevelMeter> meters;
  const RecordingDefects defects = read_recording(
      folder,
      [&](const VehicleConfig& recorded) {
        vehicle = recorded;
        for (const auto& node : vehicle.node) meters.emplace(node.id, LevelMeter(vehicle, node));
      },
      [&](const SealedBlock& block) {
        const auto meter = meters.find(block.header.node);
        if (block.kind == BlockKind::kScan && meter != meters.end()) meter->second.add(decode_scan(block));
      });
  warn_of_defects("levels", folder, defects);
  Json channels = Json::array();
  for (auto& [id, meter] : meters) {
    const auto level = meter.take();
    if (!level) continue;
    const NodeConfig& node = *vehicle.node_with_id(id);
    for (std::size_t c = 0; c < node.channel.size(); ++c)
      channels.push_back({{"channel", node.channel[c].name},
                          {"node", node.name},
                          {"unit", "m/s^2"},
                          {"mean", level->mean[c]},
                          {"rms", level->rms[c]},
                          {"peak", level->peak[c]},
                          {"seconds", level->seconds},
                          {"overload", (level->overload >> c & 1U) != 0},
                          {"dead", (level->dead >> c & 1U) != 0}});
  }
  return {{"channels", channels}};
}

int levels(const LevelsOptions& options) {
  const Json result = levels_of(options.folder);
  if (options.json) {
    std::printf("%s\n", result.dump().c_str());
  } else {
    std::printf("%-24s %10s %10s %10s   m/s^2; rms and peak about the mean\n", "channel", "mean", "rms",
                "peak");
    for (const auto& channel : result["channels"])
      std::printf("%-24s %10.3f %10.3f %10.3f%s%s\n", channel["channel"].get<std::string>().c_str(),
                  channel["mean"].get<double>(), channel["rms"].get<double>(), channel["peak"].get<double>(),
                  channel["overload"].get<bool>() ? "   OVERLOAD" : "",
                  channel["dead"].get<bool>() ? "   DEAD" : "");
  }
  return result["channels"].empty() ? kAnswerIsNo : kDone;
}

}  // namespace

void add_levels(CLI::App& app, int& code) {
  auto options = std::make_shared<LevelsOptions>();
  CLI::App* command = app.add_subcommand("levels", "Mean, rms and peak of every channel of a recording");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = levels(*options); });
}

}  // namespace roadbalance
