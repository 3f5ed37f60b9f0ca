#include "tools/demonstration/demo_report.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "common/command_line/exit_code.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/wheels_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// Sums over the epochs of one node; there is one unless it was restarted.
Json node_json(const NodeConfig& node, const std::vector<NodeReport>& recorded) {
  NodeReport sum;
  for (const NodeReport& report : recorded) {
    if (report.node != node.id) continue;
    sum.samples_sent += report.samples_sent;
    sum.samples_recorded += report.samples_recorded;
    sum.gaps += report.gaps;
    sum.repaired += report.repaired;
  }
  return {{"name", node.name},
          {"samples_sent", sum.samples_sent},
          {"samples_recorded", sum.samples_recorded},
          {"gaps", sum.gaps},
          {"repaired", sum.repaired}};
}

}  // namespace

std::vector<std::string> demo_lines(const BusView& view, const sim::Truth& truth) {
  std::vector<std::string> lines{identification_line(view.identification().value_or(Identification{}))};
  for (std::size_t w = 0; w < kWheels; ++w) {
    Balance nothing;
    nothing.wheel = static_cast<std::int32_t>(w);
    char text[64];
    std::snprintf(text, sizeof text, "   (truth %.1f g %.1f°)", truth.wheel[w].unbalance_g,
                  truth.wheel[w].angle_deg);
    lines.push_back(balance_line(view.balance()[w].value_or(nothing)) + text);
  }
  return lines;
}

Json demo_report(const BusView& view, const sim::Truth& truth, const DemoPlan& plan,
                 const std::vector<NodeReport>& recorded) {
  std::array<Balance, kWheels> balance;
  for (std::size_t w = 0; w < kWheels; ++w) balance[w] = view.balance()[w].value_or(Balance{});
  Json wheels = wheels_json(view.identification().value_or(Identification{}), balance);
  add_truth(wheels, truth);
  Json nodes = Json::array();
  double drive_s = 0.0;
  for (const NodeConfig& node : plan.vehicle().node) {
    nodes.push_back(node_json(node, recorded));
    drive_s = std::max(drive_s, nodes.back()["samples_recorded"].get<double>() / node.rate_hz);
  }
  return {{"wheels", wheels}, {"nodes", nodes}, {"drive_s", drive_s}};
}

std::string demo_obstacle(const BusView& view) {
  std::string why;
  for (const auto& balance : view.balance()) {
    if (balance && balance->state == Unknown::kNone) return "";
    if (balance && why.empty()) why = reason(balance->state);
  }
  return why.empty() ? "the analyser said nothing" : why;
}

int demo_exit_code(const Json& report) {
  const bool any = std::any_of(report["wheels"].begin(), report["wheels"].end(),
                               [](const Json& wheel) { return !wheel["unbalance_g"].is_null(); });
  int code = any ? kDone : kAnswerIsNo;
  for (const Json& node : report["nodes"]) {
    if (node["samples_recorded"] == node["samples_sent"] && node["samples_sent"] > 0) continue;
    code = node["gaps"] > 0 && code != kAnswerIsNo ? kIncomplete : kAnswerIsNo;
  }
  return code;
}

}  // namespace roadbalance
