#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "common/process/child.hpp"
#include "tools/demonstration/demo_team.hpp"

namespace roadbalance {
namespace {

using Arguments = std::vector<std::string>;

// With a page a person may stop the recording and start another.
Arguments recorder_arguments(const DemoPlan& plan) {
  if (!plan.has_page()) return {"--url", plan.url(), "--record", plan.record().string(), "--json"};
  return {"--url",        plan.url(),
          "--recordings", plan.recordings().string(),
          "--start",      plan.record().filename().string(),
          "--vehicle",    plan.vehicle_file().string(),
          "--json"};
}

Arguments analyser_arguments(const DemoPlan& plan) {
  if (!plan.has_page()) return {"--url", plan.url(), "--record", plan.record().string(), "--exit-at-end"};
  return {"--url",        plan.url(),
          "--recordings", plan.recordings().string(),
          "--vehicle",    plan.vehicle_file().string(),
          "--exit-at-end"};
}

Arguments node_arguments(const DemoPlan& plan, const std::string& node) {
  Arguments arguments{"--url",  plan.url(), "--vehicle",   plan.vehicle_file().string(),
                      "--node", node,       "--front-end", plan.front_end()};
  if (plan.has_page()) arguments.push_back("--stay");
  return arguments;
}

class Processes final : public DemoTeam {
 public:
  explicit Processes(const DemoPlan& plan)
      : recorder_(sibling_program("rb-recorder"), recorder_arguments(plan), plan.work() / "recorder.log"),
        analyser_(sibling_program("rb-analyser"), analyser_arguments(plan), plan.work() / "analyser.log") {
    for (const auto& node : plan.vehicle().node)
      nodes_.push_back({node.name, Child(sibling_program("rb-node"), node_arguments(plan, node.name),
                                         plan.work() / (node.name + ".log"))});
  }

  bool working() override {
    if (recorder_.ended()) fail(recorder_, "rb-recorder");
    bool all_ended = ended_well(analyser_, "rb-analyser");
    for (auto& node : nodes_)
      all_ended = ended_well(node.program, "node " + node.name + " (rb-node)") && all_ended;
    return !all_ended;
  }

  std::string last_words() const override {
    std::string words = said(recorder_, "rb-recorder") + said(analyser_, "rb-analyser");
    for (const auto& node : nodes_) words += said(node.program, "node " + node.name);
    return words;
  }

  std::vector<NodeReport> finish() override {
    recorder_.stop();
    while (!ended_well(recorder_, "rb-recorder")) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    std::vector<NodeReport> reports;
    const auto counts = nlohmann::json::parse(recorder_.output());
    for (const auto& json : counts.at("nodes")) {
      NodeReport& report = reports.emplace_back();
      report.node = json.at("node").get<std::int32_t>();
      report.epoch = json.at("epoch").get<std::int64_t>();
      report.samples_sent = json.at("samples_sent").get<std::int64_t>();
      report.samples_recorded = json.at("samples_recorded").get<std::int64_t>();
      report.gaps = json.at("gaps").get<std::int64_t>();
      report.repaired = json.at("repaired").get<std::int64_t>();
    }
    return reports;
  }

 private:
  struct Node {
    std::string name;
    Child program;
  };

  static std::string said(const Child& child, const std::string& name) {
    return "; " + name + ": " + child.last_words();
  }
  [[noreturn]] static void fail(const Child& child, const std::string& name) {
    throw std::runtime_error(name + " " + child.how_it_ended());
  }
  static bool ended_well(Child& child, const std::string& name) {
    const std::optional<int> code = child.ended();
    if (code && *code != 0) fail(child, name);
    return code.has_value();
  }

  Child recorder_;
  Child analyser_;
  std::vector<Node> nodes_;
};

}  // namespace

std::unique_ptr<DemoTeam> start_processes(const DemoPlan& plan) {
  return std::make_unique<Processes>(plan);
}

}  // namespace roadbalance
