#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/process_port.hpp"
#include "common/config/validators.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/process/stop_on_signal.hpp"
#include "tools/doctor/accuracy.hpp"
#include "tools/doctor/bus_interface.hpp"
#include "tools/doctor/bus_loop.hpp"
#include "tools/doctor/devices.hpp"
#include "tools/doctor/machine.hpp"
#include "tools/doctor/recording_folder.hpp"
#include "tools/doctor/roll_call.hpp"
#include "tools/rb/command.hpp"

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

/// Findings about one subject; those that are well share a line.
struct Group {
  const char* about;
  std::vector<Finding> findings{};

  void add(std::vector<Finding> more) {
    findings.insert(findings.end(), std::make_move_iterator(more.begin()),
                    std::make_move_iterator(more.end()));
  }
};

/// Uses a private bus unless one is named, so that other programs are not disturbed.
/// @param vehicle  nullptr: none is given
/// @param heard    gets the nodes that are there
Group examine_bus(const DoctorOptions& options, const VehicleConfig* vehicle, std::set<std::int32_t>& heard) {
  constexpr std::chrono::seconds kListen{1};  // a node sends ten messages in it, a recorder two
  Group bus{"bus"};
  bus.add(examine_way(options.url));
  try {
    std::optional<RollCall> roll;
    if (!options.url.empty()) roll.emplace(options.url);
    BusLoop loop(options.url.empty() ? bus_url_on_port(process_port()) : options.url);
    loop.run(options.messages);
    bus.add({receive_buffer(loop.receive_buffer())});
    bus.add(loop_findings(loop, options.url));
    if (!roll) return bus;
    roll->listen(kListen);
    bus.add(roll->findings(vehicle, options.vehicle));
    heard = roll->nodes();
  } catch (const std::exception& error) {
    // Without a route the first finding names the cause already.
    if (bus.findings.front().state != Finding::kIll)
      bus.add({{"loopback", Finding::kIll, std::string("LCM does not start: ") + error.what(), ""}});
  }
  return bus;
}

/// Examines the node that is named, or all where there is no bus: those on a bus have computers of their own.
Group examine_devices(const DoctorOptions& options, const VehicleConfig& vehicle,
                      const std::set<std::int32_t>& heard) {
  Group devices{"devices"};
  if (options.node.empty() && !options.url.empty()) return devices;
  for (const NodeConfig& node : vehicle.node) {
    if (!options.node.empty() && node.name != options.node) continue;
    if (heard.contains(node.id))
      devices.add({{"devices", Finding::kWell, "Node " + node.name + " runs, and has its own.", ""}});
    else
      devices.add(device_findings(vehicle, node));
  }
  return devices;
}

void print(const std::vector<Group>& groups) {
  for (const auto& [state, mark] : {std::pair(Finding::kIll, "ill   "), std::pair(Finding::kNote, "note  ")})
    for (const Group& group : groups)
      for (const Finding& finding : group.findings) {
        if (finding.state != state) continue;
        std::printf("%s%s\n", mark, finding.sentence.c_str());
        if (!finding.remedy.empty()) std::printf("        mend it with: %s\n", finding.remedy.c_str());
      }
  for (const Group& group : groups) {
    std::string well;
    for (const Finding& finding : group.findings)
      if (finding.state == Finding::kWell) well += " " + finding.sentence;
    if (!well.empty()) std::printf("ok    %s:%s\n", group.about, well.c_str());
  }
}

nlohmann::ordered_json list_of(const std::vector<Group>& groups) {
  auto list = nlohmann::ordered_json::array();
  for (const Group& group : groups)
    for (const Finding& finding : group.findings)
      list.push_back({{"name", finding.name},
                      {"about", group.about},
                      {"ok", finding.state == Finding::kWell},
                      {"needed", finding.state == Finding::kIll},
                      {"finding", finding.sentence},
                      {"remedy", finding.remedy.empty() ? nullptr : nlohmann::ordered_json(finding.remedy)}});
  return list;
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
  std::optional<VehicleConfig> vehicle;
  if (!options.vehicle.empty()) vehicle = VehicleConfig::read_file(options.vehicle);
  if (!options.node.empty()) (void)vehicle->node_named(options.node);  // its error lists those that exist
  std::set<std::int32_t> heard;
  std::vector<Group> groups{examine_bus(options, vehicle ? &*vehicle : nullptr, heard)};
  groups.push_back({"folder", examine_folder(options.folder, vehicle ? rate_of(*vehicle) : ordinary_rate())});
  groups.push_back({"machine", examine_machine(std::chrono::milliseconds(
                                   static_cast<std::int64_t>(1000.0 * options.seconds)))});
  if (vehicle) {
    groups.push_back(examine_devices(options, *vehicle, heard));
    groups.push_back({"vehicle", accuracy_findings(*vehicle, options.vehicle)});
  }
  const bool well = std::ranges::none_of(groups, [](const Group& group) {
    return std::ranges::any_of(group.findings,
                               [](const Finding& finding) { return finding.state == Finding::kIll; });
  });
  if (options.json)
    std::printf("%s\n", nlohmann::ordered_json{{"ok", well}, {"findings", list_of(groups)}}.dump().c_str());
  else
    print(groups);
  return well ? kDone : kAnswerIsNo;
}

}  // namespace

void add_doctor(CLI::App& app, int& code) {
  auto options = std::make_shared<DoctorOptions>();
  CLI::App* command =
      app.add_subcommand("doctor", "Says what costs data or accuracy here, and the command that mends it");
  command->add_option("--folder", options->folder, "where recordings will be written")->capture_default_str();
  command
      ->add_option("--seconds", options->seconds,
                   "how long the wake-ups of threads are measured; load the machine meanwhile as it will be")
      ->check(number_within(0.1, 86'400.0))
      ->capture_default_str();
  CLI::Option* const url = command
                               ->add_option("--url", options->url,
                                            "LCM address of the bus; its nodes are listened to, and "
                                            "machines on which rb doctor --answer runs are asked; "
                                            "default: a bus of its own on this machine")
                               ->envname(kBusUrlVariable);
  command
      ->add_option("--messages", options->messages,
                   "that are sent over it, each of the size of a block, 1000 a second")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  CLI::Option* const vehicle = command->add_option(
      "--vehicle", options->vehicle,
      "vehicle.toml: says what of it costs accuracy; opens the devices of its nodes, as rb-node "
      "does, and lets them go, or with --url names those of its nodes that are not "
      "heard");
  command->add_option("--node", options->node, "opens the devices of this node only")->needs(vehicle);
  command
      ->add_flag("--answer", options->answer,
                 "answers the messages of rb doctor on other machines, until Ctrl-C")
      ->needs(url);
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = examine(*options); });
}

}  // namespace roadbalance
