#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/bus/bus.hpp"
#include "common/bus/process_port.hpp"
#include "common/config/validators.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/process/stop_on_signal.hpp"
#include "tools/rb/bus_loop.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/devices.hpp"
#include "tools/rb/machine.hpp"

namespace roadbalance {
namespace {

struct DoctorOptions {
  std::string folder = "recordings";
  std::string vehicle, node, url;
  double seconds = 2.0;
  int messages = 1000;
  bool answer = false;
  bool json = false;
};

/// Of its own bus, unless one is named: nobody else is disturbed then.
std::vector<Finding> examine_bus(const DoctorOptions& options) {
  try {
    BusLoop loop(options.url.empty() ? bus_url_on_port(process_port()) : options.url);
    loop.run(options.messages);
    return loop_findings(loop, options.url);
  } catch (const std::exception& error) {
    return {{"loopback", Finding::kIll, std::string("LCM does not start: ") + error.what(),
             std::string("sudo sh -c '") + kMulticastRemedy + "'"}};
  }
}

std::vector<Finding> examine_devices(const DoctorOptions& options) {
  const VehicleConfig vehicle = VehicleConfig::read_file(options.vehicle);
  std::vector<Finding> all;
  for (const NodeConfig& node : vehicle.node)
    if (options.node.empty() || node.name == options.node)
      for (Finding& finding : device_findings(vehicle, node)) all.push_back(std::move(finding));
  if (all.empty()) (void)vehicle.node_named(options.node);  // says which there are
  return all;
}

int answer(const DoctorOptions& options) {
  const StopOnSignal signals;
  std::fprintf(stderr, "answers whoever asks on %s, until Ctrl-C\n", options.url.c_str());
  const std::int64_t answered = answer_loops(options.url, signals.token());
  if (options.json)
    std::printf("%s\n", nlohmann::ordered_json{{"answered", answered}}.dump().c_str());
  else
    std::fprintf(stderr, "%lld messages answered\n", static_cast<long long>(answered));
  return kDone;
}

int examine(const DoctorOptions& options) {
  if (options.answer) return answer(options);
  std::vector<Finding> findings = examine_machine(
      options.folder, std::chrono::milliseconds(static_cast<std::int64_t>(1000.0 * options.seconds)));
  for (Finding& finding : examine_bus(options)) findings.push_back(std::move(finding));
  if (!options.vehicle.empty())
    for (Finding& finding : examine_devices(options)) findings.push_back(std::move(finding));
  bool well = true;
  auto list = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    well = well && finding.state != Finding::kIll;
    if (options.json) {
      list.push_back({{"name", finding.name},
                      {"ok", finding.state == Finding::kWell},
                      {"needed", finding.state == Finding::kIll},
                      {"finding", finding.sentence},
                      {"remedy", finding.remedy.empty() ? nullptr : nlohmann::ordered_json(finding.remedy)}});
      continue;
    }
    static constexpr const char* kMark[] = {"ok    ", "note  ", "ill   "};
    std::printf("%s %s\n", kMark[finding.state], finding.sentence.c_str());
    if (!finding.remedy.empty()) std::printf("        mend it with: %s\n", finding.remedy.c_str());
  }
  if (options.json)
    std::printf("%s\n", nlohmann::ordered_json{{"ok", well}, {"findings", list}}.dump().c_str());
  return well ? kDone : kAnswerIsNo;
}

}  // namespace

void add_doctor(CLI::App& app, int& code) {
  auto options = std::make_shared<DoctorOptions>();
  CLI::App* command =
      app.add_subcommand("doctor", "Says what this machine lacks, and the command that mends it");
  command->add_option("--folder", options->folder, "where recordings will be written")->capture_default_str();
  command
      ->add_option("--seconds", options->seconds,
                   "how long the wake-ups of threads are measured; load the machine meanwhile as it will be")
      ->check(number_within(0.1, 86'400.0))
      ->capture_default_str();
  CLI::Option* const url = command->add_option("--url", options->url,
                                               "LCM address of the bus; its nodes are listened to, and "
                                               "machines on which rb doctor --answer runs are asked; "
                                               "default: a bus of its own on this machine");
  command
      ->add_option("--messages", options->messages,
                   "that are sent over it, each of the size of a block, 1000 a second")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  CLI::Option* const vehicle =
      command->add_option("--vehicle", options->vehicle,
                          "vehicle.toml: opens the devices of its nodes, as rb-node does, and lets them go");
  command->add_option("--node", options->node, "of this node only")->needs(vehicle);
  command
      ->add_flag("--answer", options->answer,
                 "answers the messages of rb doctor on other machines, until Ctrl-C")
      ->needs(url);
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = examine(*options); });
}

}  // namespace roadbalance
