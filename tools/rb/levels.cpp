#include "host/analyser/levels.hpp"

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/bus/channel_faults.hpp"
#include "common/bus/codec.hpp"
#include "common/text/format.hpp"
#include "host/analyser/channel_watch.hpp"
#include "host/analyser/levels_in_time.hpp"
#include "host/analyser/read_recording.hpp"
#include "host/analyser/wheel_speeds.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/defects.hpp"
#include "tools/rb/degrees.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct LevelsOptions {
  std::string folder;
  bool json = false;
};

/// Of a node: over the whole recording, and each tenth of a second as the analyser tells it live.
class NodeLevels {
 public:
  NodeLevels(const VehicleConfig& vehicle, const NodeConfig& node)
      : whole_(vehicle, node), interval_(vehicle, node) {}

  void add(const ScanBlock& block, ChannelWatch& watch, LevelsInTime& in_time) {
    whole_.add(block);
    interval_.add(block);
    seconds_ += 1e-12 * static_cast<double>(block.period_ps * block.header.scans);
    if (seconds_ < kInterval_s) return;
    seconds_ = 0.0;
    auto level = interval_.take();
    watch.judge(*level);
    in_time.take(block.header.epoch, *level);
    for (std::size_t c = 0; c < kAccelerations; ++c) {
      if (is_dead(*level, c)) dead_s[c] += level->seconds;
      if (is_railed(*level, c)) railed_s[c] += level->seconds;
    }
  }
  std::optional<Level> whole() { return whole_.take(); }

  std::array<double, kAccelerations> dead_s{}, railed_s{};

 private:
  static constexpr double kInterval_s = 0.1;
  LevelMeter whole_, interval_;
  double seconds_ = 0.0;
};

/// Of the wheels that turned.
Json speeds_json(const WheelSpeeds& speeds) {
  const auto known = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  Json wheels = Json::array(), classes = Json::array();
  const auto all = speeds.wheels();
  for (std::size_t w = 0; w < kWheels; ++w) {
    if (all[w].seconds == 0.0) continue;
    Json drift;
    for (std::size_t other = 0; other < kWheels; ++other)
      if (other != w && all[other].seconds > 0.0)
        drift[kWheelNames[other]] =
            known(degrees(speeds.drift_rad(static_cast<int>(w), static_cast<int>(other))));
    wheels.push_back({{"wheel", kWheelNames[w]},
                      {"seconds", all[w].seconds},
                      {"turns", all[w].turns},
                      {"slip", known(all[w].slip)},
                      {"drift_deg", drift}});
  }
  for (const auto& [place, seconds] : speeds.classes())
    classes.push_back({{"from_m_s", place * speeds.class_m_s()},
                       {"to_m_s", (place + 1) * speeds.class_m_s()},
                       {"seconds", seconds}});
  return {{"wheels", wheels}, {"speed_classes", classes}};
}

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

/// Levels of every channel over the whole recording.
Json levels_of(const std::string& folder) {
  VehicleConfig vehicle;
  std::map<std::int32_t, NodeLevels> meters;
  std::optional<ChannelWatch> watch;
  std::optional<WheelSpeeds> speeds;
  LevelsInTime in_time([&](const Level& level) { speeds->take(level); });
  const RecordingDefects defects = read_recording(
      folder,
      [&](const VehicleConfig& recorded) {
        vehicle = recorded;
        watch.emplace(vehicle);
        speeds.emplace(vehicle);
        for (const auto& node : vehicle.node) meters.emplace(node.id, NodeLevels(vehicle, node));
      },
      [&](const SealedBlock& block) {
        const auto meter = meters.find(block.header.node);
        if (block.kind == BlockKind::kScan && meter != meters.end())
          meter->second.add(decode_scan(block), *watch, in_time);
      },
      [&](const ClockFit& fit) { in_time.take(fit); });
  in_time.flush();
  warn_of_defects("levels", folder, defects);
  Json channels = Json::array();
  for (auto& [id, meter] : meters) {
    const auto level = meter.whole();
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
                          {"dead", meter.dead_s[c] > 0.0},
                          {"dead_s", meter.dead_s[c]},
                          {"dc_offset_s", meter.railed_s[c]}});
  }
  Json result{{"channels", channels}};
  result.update(speeds_json(*speeds));
  return result;
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
      std::printf("%-24s %10.3f %10.3f %10.3f%s%s%s\n", channel["channel"].get<std::string>().c_str(),
                  channel["mean"].get<double>(), channel["rms"].get<double>(), channel["peak"].get<double>(),
                  channel["overload"].get<bool>() ? "   OVERLOAD" : "",
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
      "Mean, rms and peak of every channel of a recording, dead channels and offsets; slip and "
      "drift of the wheels, how long each speed was driven");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = levels(*options); });
}

}  // namespace roadbalance
