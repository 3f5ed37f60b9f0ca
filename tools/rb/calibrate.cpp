#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "host/analysis/calibration/channel_comparison.hpp"
#include "host/recording/read_recording.hpp"
#include "tools/datum/vehicle_file.hpp"
#include "tools/rb/command.hpp"
#include "tools/views/recording_defects.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct CalibrateOptions {
  std::string folder, vehicle, node;
  ChannelComparison::Settings settings;
  bool dry_run = false, json = false;
};

struct NodeResult {
  std::string name;
  ChannelComparison::Result found;
};

/// One node's channels; a recording of several nodes compares each node's own.
std::vector<NodeResult> compare(const CalibrateOptions& options) {
  std::map<std::int32_t, std::pair<std::string, std::unique_ptr<ChannelComparison>>> nodes;
  const RecordingDefects defects = read_recording(
      options.folder,
      [&](const VehicleConfig& vehicle) {
        if (!options.node.empty()) vehicle.node_named(options.node);
        for (const NodeConfig& node : vehicle.node)
          if (options.node.empty() ? ChannelComparison::has_reference(node, options.settings)
                                   : node.name == options.node)
            nodes[node.id] = {node.name, std::make_unique<ChannelComparison>(node, options.settings)};
        if (nodes.empty())
          throw ConfigError("--reference-channel " + options.settings.reference +
                            ": no node has such a channel in use");
      },
      [&](const SealedBlock& block) {
        const auto node = nodes.find(block.header.node);
        if (block.kind == BlockKind::kScan && node != nodes.end())
          node->second.second->add(decode_scan(block));
      });
  warn_of_defects("calibrate", options.folder, defects);
  std::vector<NodeResult> results;
  for (const auto& [id, node] : nodes) results.push_back({node.first, node.second->result()});
  return results;
}

const char* said(ChannelMatch::Verdict verdict) {
  switch (verdict) {
    case ChannelMatch::Verdict::kMatched:
      return "matched";
    case ChannelMatch::Verdict::kNoCoherence:
      return "no coherence";
    case ChannelMatch::Verdict::kInverted:
      return "inverted";
    case ChannelMatch::Verdict::kNoDelay:
      return "no delay";
    case ChannelMatch::Verdict::kOtherSize:
      return "other size";
  }
  return "";
}

/// The remedy, in words.
const char* remedy(ChannelMatch::Verdict verdict) {
  switch (verdict) {
    case ChannelMatch::Verdict::kMatched:
      return "";
    case ChannelMatch::Verdict::kNoCoherence:
      return "it does not show the signal of the others: is it connected?";
    case ChannelMatch::Verdict::kInverted:
      return "it shows the signal upside down: swap its two wires";
    case ChannelMatch::Verdict::kNoDelay:
      return "it differs by more than a gain and a delay: its filter is another one";
    case ChannelMatch::Verdict::kOtherSize:
      return "it shows the signal more than 20 % larger or smaller than the others do: is it connected, and "
             "its "
             "range that of vehicle.toml?";
  }
  return "";
}

std::vector<ValueToSet> values(const std::vector<NodeResult>& nodes) {
  std::vector<ValueToSet> all;
  for (const NodeResult& node : nodes)
    for (const auto& channel : node.found.channel) {
      if (!channel.can_be_set) continue;
      const TablePath calibration{{"node", node.name}, {"channel", channel.name}, {"calibration"}};
      char scale[32];
      std::snprintf(scale, sizeof scale, "%.9g", channel.scale_m_s2_per_count);
      all.push_back({calibration, "scale_m_s2_per_count", scale});
      all.push_back({calibration, "offset_counts", toml_number(channel.offset_counts, 3)});
      all.push_back({calibration, "delay_us", toml_number(channel.delay_s * 1e6, 3)});
    }
  return all;
}

Json json_of(const ChannelComparison::Channel& channel) {
  const ChannelMatch& match = channel.match;
  const bool seen = match.verdict != ChannelMatch::Verdict::kNoCoherence;
  const auto known = [](bool is_known, double value) { return is_known ? Json(value) : Json(nullptr); };
  return {{"channel", channel.name},
          {"verdict", said(match.verdict)},
          {"coherence", match.coherence},
          {"gain", known(seen, match.gain)},
          {"gain_sigma", known(seen, match.gain_sigma)},
          {"delay_us", known(seen, match.delay_s * 1e6)},
          {"delay_sigma_us", known(seen, match.delay_sigma_s * 1e6)},
          {"misfit_deg", known(seen, match.misfit_rad * 180.0 / std::numbers::pi)},
          {"scale_m_s2_per_count", known(channel.can_be_set, channel.scale_m_s2_per_count)}};
}

void print(const NodeResult& node) {
  std::printf("node %s, %.0f s\n%-24s %19s %22s  18 Hz   %9s\n", node.name.c_str(), node.found.seconds,
              "channel", "gain, % off", "delay, us", "coherence");
  for (const auto& channel : node.found.channel) {
    const ChannelMatch& match = channel.match;
    if (match.verdict == ChannelMatch::Verdict::kNoCoherence)
      std::printf("%-24s %52s %9.4f\n", channel.name.c_str(), "", match.coherence);
    else
      std::printf("%-24s %+9.3f +- %6.3f %+11.2f +- %7.2f %+7.3f° %9.4f\n", channel.name.c_str(),
                  100.0 * (match.gain - 1.0), 100.0 * match.gain_sigma, 1e6 * match.delay_s,
                  1e6 * match.delay_sigma_s, 360.0 * 18.0 * match.delay_s, match.coherence);
  }
}

int calibrate(const CalibrateOptions& options) {
  const auto nodes = compare(options);
  bool all_matched = true;
  Json list = Json::array();
  for (const NodeResult& node : nodes) {
    if (!options.json && !node.found.channel.empty()) print(node);
    if (node.found.overload_s > 0.0)
      std::fprintf(stderr, "rb calibrate: node %s: %.1f s are left out, in which an input was overloaded\n",
                   node.name.c_str(), node.found.overload_s);
    if (!node.found.refusal.empty())
      std::fprintf(stderr, "rb calibrate: node %s: %s\n", node.name.c_str(), node.found.refusal.c_str());
    all_matched = all_matched && !node.found.channel.empty();
    Json channels = Json::array();
    for (const auto& channel : node.found.channel) {
      channels.push_back(json_of(channel));
      if (channel.match.verdict == ChannelMatch::Verdict::kMatched) continue;
      all_matched = false;
      std::fprintf(stderr, "rb calibrate: %s is left as it is: %s\n", channel.name.c_str(),
                   remedy(channel.match.verdict));
    }
    list.push_back({{"node", node.name},
                    {"seconds", node.found.seconds},
                    {"overload_s", node.found.overload_s},
                    {"obstacle", node.found.refusal.empty() ? Json() : Json(node.found.refusal)},
                    {"channels", channels}});
  }
  const auto to_set = values(nodes);
  const bool write = !to_set.empty() && !options.vehicle.empty() && !options.dry_run;
  if (write) set_in_vehicle_file(options.vehicle, to_set);
  if (options.json)
    std::printf("%s\n", Json{{"nodes", list}, {"written", write}}.dump().c_str());
  else if (write)
    std::printf("%s has the calibration of %zu channels now, as it was it is in %s.bak\n",
                options.vehicle.c_str(), to_set.size() / 3, options.vehicle.c_str());
  return all_matched ? kDone : kAnswerIsNo;
}

}  // namespace

void add_calibrate(CLI::App& app, int& code) {
  auto options = std::make_shared<CalibrateOptions>();
  CLI::App* calibrations =
      app.add_subcommand("calibrate", "Calibrations that need a recording made for them");
  calibrations->require_subcommand(1);
  CLI::App* command = calibrations->add_subcommand(
      "channels",
      "Gain and delay of channels against each other, from a recording of one signal on all inputs");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_option("--vehicle", options->vehicle, "vehicle.toml to set each channel's calibration in");
  command->add_flag("--dry-run", options->dry_run, "change no file");
  command->add_option("--node", options->node, "this node's channels only; default: every node's");
  command->add_option(
      "--reference-channel", options->settings.reference,
      "stays as it is, of nodes that have it; default: the median, for delays that of the loop-back if there "
      "is one");
  command->add_flag("--motion", options->settings.motion,
                    "all sensors felt one motion; default: all inputs were given one voltage");
  command->add_option("--low-hz", options->settings.low_hz, "band that is compared")
      ->check(number_within(0.1, 1e4))
      ->capture_default_str();
  command->add_option("--high-hz", options->settings.high_hz, "its upper end")
      ->check(number_within(0.1, 1e4))
      ->capture_default_str();
  command->add_option("--segment-s", options->settings.segment_s, "length of the averaged segments, s")
      ->check(number_within(0.01, 100.0))
      ->capture_default_str();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = calibrate(*options); });
}

}  // namespace roadbalance
