#include <chrono>
#include <exception>
#include <functional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/command_line/bus_url.hpp"
#include "common/command_line/manual.hpp"
#include "common/command_line/run_program.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "common/frontend/unopened_wiring.hpp"
#include "common/process/pause.hpp"
#include "common/process/service_notify.hpp"
#include "common/process/stop_on_signal.hpp"
#include "common/types/clocks.hpp"
#include "firmware/backends/front_ends.hpp"
#include "firmware/missing_signals.hpp"
#include "firmware/node_service.hpp"
#include "sim/front_end.hpp"

using namespace roadbalance;

namespace {
constexpr std::chrono::seconds kLeastLife{1};

void warn(const std::string& of) {
  report("rb-node", "warning: " + of);
}
void inform(const std::string& of) {
  report("rb-node", of);
}
std::function<void()> feed(ServiceNotify& notify) {
  return [&notify, is_ready = false]() mutable {
    if (!std::exchange(is_ready, true)) notify.ready();
    notify.feed();
  };
}
}  // namespace

int main(int argc, char** argv) {
  const StopOnSignal signals;
  const WallTime began = WallClock::now();
  CLI::App app("Samples one node of the vehicle and streams its blocks to the recorder.", "rb-node");
  std::string vehicle_file, node_name, bus_url;
  std::vector<std::string> front_end_uris;
  double ring_mib = 16.0;
  app.add_option("--vehicle", vehicle_file, "vehicle.toml")->required();
  app.add_option("--node", node_name, "name of this node in vehicle.toml")->required();
  app.add_option(
      "--front-end", front_end_uris,
      "where samples come from, e.g. sim:?seed=1 or usb:1209:0001; again for each device beside it, "
      "e.g. gpio:gpiochip0 and can:can0; default: front_end of the node in vehicle.toml");
  add_bus_url(app, bus_url);
  app.add_option("--ring-mib", ring_mib, "memory for blocks the recorder does not have yet, MiB")
      ->check(number_within(0.25, 4096.0))
      ->capture_default_str();
  std::string spool;
  double spool_mib = 1024.0;
  app.add_option("--spool", spool, "folder for blocks when the memory is half full; none: memory only");
  app.add_option("--spool-mib", spool_mib, "what the spool may take of the disk, MiB")
      ->check(number_within(1.0, 1048576.0))
      ->capture_default_str();
  bool stays = false;
  app.add_flag("--stay", stays, "when a recording is stopped wait for the next; default: exit");
  add_version(app);
  add_manual(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return report_failure(app, error);
  }
  try {
    ServiceNotify notify;
    const std::stop_callback notify_stopping(signals.token(), [&notify] { notify.stopping(); });
    const VehicleConfig vehicle = VehicleConfig::read_file(vehicle_file);
    FrontEndRegistry front_ends = real_front_ends(warn, inform);
    front_ends.add("sim", sim::open_sim_front_end);
    const auto open = [&](const VehicleConfig& car, const NodeConfig& of) {
      const auto& uris = front_end_uris.empty() ? of.wiring.front_end : front_end_uris;
      auto front_end = front_ends.open(uris, car, of);
      for (const std::string& unread : unopened_wiring(of, uris)) warn(unread);
      for (const std::string& missing : missing_signals(car, of)) warn(missing);
      return front_end;
    };
    const auto& wired = vehicle.node_named(node_name).wiring.front_end;
    const ConverterSettings device = converter_settings(front_end_uris.empty() ? wired : front_end_uris);
    const std::int64_t lost = serve_node(signals.token(), vehicle, node_name, open, device, stays,
                                         {.bus_url = bus_url,
                                          .ring_bytes = static_cast<std::size_t>(ring_mib * 1024 * 1024),
                                          .spool = spool,
                                          .spool_bytes = static_cast<std::uint64_t>(spool_mib * 1024 * 1024),
                                          .warn = warn,
                                          .on_alive = feed(notify)});
    return lost > 0 ? 3 : 0;
  } catch (const ConfigError& error) {
    return report_failure(app, error);
  } catch (const std::exception& error) {
    const int code = report_failure(app, error);
    // It is started again at once; while a device is not there that is once a second, not ten times.
    if (stays) pause(signals.token(), began + kLeastLife - WallClock::now());
    return code;
  }
}
