#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "common/types/angle_units.hpp"
#include "host/analysis/calibration/loop_back_comparison.hpp"
#include "host/recording/read_recording.hpp"
#include "tools/rb/command.hpp"
#include "tools/views/recording_defects.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct WiringOptions {
  std::string folder;
  double tolerance_deg = 0.1;
  bool json = false;
};

struct NodeTest {
  NodeTest(const VehicleConfig& vehicle, const NodeConfig& node, EdgeMemory memory)
      : computed(vehicle, node, memory), comparison(node.rate_hz) {}

  ComputedReferences computed;
  LoopBackComparison comparison;
};

/// Compares what came back in every node that has a loop-back; the recording is read twice.
VehicleConfig compare(const std::string& folder, std::map<std::int32_t, NodeTest>& nodes) {
  VehicleConfig recorded;
  const auto begin = [&](const VehicleConfig& vehicle) {
    recorded = vehicle;
    const EdgeMemory share(available_memory() / static_cast<double>(vehicle.node.size()));
    for (const NodeConfig& node : vehicle.node)
      if (node.wiring.loop_back) nodes.try_emplace(node.id, vehicle, node, share);
  };
  const RecordingDefects defects = read_recording(folder, begin, [&](const SealedBlock& block) {
    if (const auto node = nodes.find(block.header.node); node != nodes.end())
      node->second.computed.learn(block);
  });
  warn_of_defects("wiring", folder, defects);
  if (nodes.empty())
    throw ConfigError("recording " + folder +
                      ": no node has a loop-back (loop_back = true), whose wiring could be tested");
  const auto again = [](const VehicleConfig&) {};
  static_cast<void>(read_recording(folder, again, [&](const SealedBlock& sealed) {
    const auto node = nodes.find(sealed.header.node);
    if (node == nodes.end() || sealed.kind != BlockKind::kScan) return;
    const ScanBlock block = decode_scan(sealed);
    node->second.comparison.add(block, node->second.computed.of(block));
  }));
  return recorded;
}

/// The probable fault, or why there was no test; empty: none.
std::string cause_of(const WheelConfig& wheel, const LoopBackComparison::Verdict& verdict,
                     const FilterConfig& filter) {
  if (verdict.cause == LoopBackComparison::Cause::kTooShort && !wheel.encoder.zero_mark)
    return "its encoder has no zero mark, so that its angle is never known: there is nothing to compare with";
  return explain(verdict, filter);
}

Json json_of(const WheelConfig& wheel, const NodeConfig& node, const LoopBackComparison::Verdict& verdict,
             const FilterConfig& filter) {
  return {{"wheel", wheel.name},
          {"node", node.name},
          {"tested", verdict.cause != LoopBackComparison::Cause::kTooShort},
          {"good", verdict.cause == LoopBackComparison::Cause::kNone},
          {"seconds", verdict.seconds},
          {"angle_error_deg", verdict.worst_rad * kDegrees},
          {"at_hz", verdict.worst_hz},
          {"mean_error_deg", verdict.mean_rad * kDegrees},
          {"delay_us", verdict.delay_s * 1e6},
          {"gain", verdict.gain},
          {"cause", cause_of(wheel, verdict, filter)}};
}

void print(const Json& wheel) {
  std::printf("%-12s %s", wheel["wheel"].get<std::string>().c_str(),
              !wheel["tested"].get<bool>() ? "not tested"
              : wheel["good"].get<bool>()  ? "good"
                                           : "WRONG");
  if (wheel["gain"].get<double>() > 0.0)
    std::printf(": angle off by %+.3f deg in the mean, %+.3f deg at %.1f turns a second, gain %.3f, %.0f s",
                wheel["mean_error_deg"].get<double>(), wheel["angle_error_deg"].get<double>(),
                wheel["at_hz"].get<double>(), wheel["gain"].get<double>(), wheel["seconds"].get<double>());
  const std::string cause = wheel["cause"];
  std::printf("%s%s\n", cause.empty() ? "" : "\n             ", cause.c_str());
}

int wiring(const WiringOptions& options) {
  std::map<std::int32_t, NodeTest> nodes;
  const VehicleConfig vehicle = compare(options.folder, nodes);
  Json wheels = Json::array();
  bool good = true;
  for (const WheelConfig& wheel : vehicle.wheel) {
    if (wheel.node.empty() || !wheel.encoder.counter.empty()) continue;
    const NodeConfig& node = vehicle.node_named(wheel.node);
    const auto test = nodes.find(node.id);
    if (test == nodes.end()) continue;
    const auto verdict = test->second.comparison.verdict(static_cast<std::size_t>(wheel.line),
                                                         options.tolerance_deg / kDegrees);
    wheels.push_back(json_of(wheel, node, verdict, vehicle.filter));
    good = good && verdict.cause == LoopBackComparison::Cause::kNone;
  }
  if (options.json)
    std::printf("%s\n", Json{{"wheels", wheels}, {"good", good}}.dump().c_str());
  else
    for (const Json& wheel : wheels) print(wheel);
  if (wheels.empty())
    std::fprintf(stderr, "rb wiring: no wheel's encoder is read by a node with a loop-back\n");
  return good && !wheels.empty() ? kDone : kAnswerIsNo;
}

}  // namespace

void add_wiring(CLI::App& app, int& code) {
  auto options = std::make_shared<WiringOptions>();
  CLI::App* command = app.add_subcommand("wiring",
                                         "Compares references that came back through the real filter with "
                                         "those computed from the edges, which are in "
                                         "memory at once: up to 100 bytes an edge");
  command->add_option("folder", options->folder, "the recording, of a node with loop_back = true")
      ->required();
  command->add_option("--tolerance-deg", options->tolerance_deg, "an angle error that is none")
      ->check(number_within(0.001, 45.0))
      ->capture_default_str();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = wiring(*options); });
}

}  // namespace roadbalance
