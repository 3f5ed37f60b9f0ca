#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <fstream>
#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "common/frontend/registry.hpp"
#include "common/process/pause.hpp"
#include "common/process/stop_on_signal.hpp"
#include "firmware/backends/replay/front_end.hpp"
#include "hil_tests/players/player.hpp"
#include "sim/front_end.hpp"

using namespace roadbalance;

namespace {

struct Options {
  std::string vehicle, source, report;
  std::vector<std::string> nodes;
  double lead_s = 5.0;
};

int play(const Options& options, const std::stop_token& stop) {
  const VehicleConfig vehicle = VehicleConfig::read_file(options.vehicle);
  FrontEndRegistry sources;
  sources.add("sim", sim::open_sim_front_end);
  sources.add("replay", [](const FrontEndRequest& request) { return open_replay_front_end(request); });
  std::vector<test::Player::Part> parts;
  for (const NodeConfig& node : vehicle.node)
    if (options.nodes.empty() || std::ranges::find(options.nodes, node.name) != options.nodes.end())
      parts.push_back(
          {node, test::read_drive(*sources.open(options.source, vehicle, node), node.name, node.rate_hz)});
  for (const std::string& name : options.nodes) static_cast<void>(vehicle.node_named(name));

  test::Player player(vehicle, std::move(parts), std::chrono::duration<double>(options.lead_s));
  std::printf("rb-play: boards are plugged in; the drive begins in %.1f s\n", options.lead_s);
  std::fflush(stdout);
  player.run(stop);
  const std::string report = player.report(), shortfall = player.shortfall();
  std::printf("%s\n", report.c_str());
  std::fflush(stdout);
  if (!options.report.empty() && !(std::ofstream(options.report) << report << std::flush))
    throw std::runtime_error("cannot write " + options.report);
  if (!shortfall.empty()) throw std::runtime_error(shortfall);
  while (pause(stop, std::chrono::hours(24)))
    ;
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const StopOnSignal signals;
  CLI::App app{
      "rb-play: plays a drive, simulated or recorded, into the USB, GPIO and CAN of this machine, as "
      "vehicle.toml "
      "says its nodes are wired; afterwards the boards stay plugged in until it is told to stop"};
  Options options;
  app.add_option("--vehicle", options.vehicle, "vehicle.toml")->required();
  app.add_option("--front-end", options.source,
                 "the drive: sim:?rate=max&seconds=60 or replay:FOLDER?rate=max")
      ->required();
  app.add_option("--node", options.nodes, "only this node; may be repeated; default: all of the vehicle");
  app.add_option("--lead", options.lead_s, "seconds until the drive begins, for the nodes to start")
      ->check(CLI::Range(0.5, 600.0))
      ->capture_default_str();
  app.add_option("--report", options.report, "file for what was played, as JSON; it is printed anyway");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return play(options, signals.token());
  } catch (const ConfigError& error) {
    std::fprintf(stderr, "rb-play: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb-play: %s\n", error.what());
    return 4;
  }
}
