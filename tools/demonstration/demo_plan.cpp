#include "tools/demonstration/demo_plan.hpp"

#include <cerrno>
#include <chrono>
#include <fstream>
#include <sstream>
#include <system_error>

#include "common/bus/bus.hpp"
#include "common/bus/quiet_port.hpp"
#include "common/config/section.hpp"
#include "common/types/clocks.hpp"
#include "embedded/demo_vehicle.hpp"

namespace roadbalance {
namespace {

VehicleConfig read_vehicle(const std::string& file) {
  if (file.empty()) return VehicleConfig::parse(std::string(embedded::kDemoVehicle), "sim/demo/vehicle.toml");
  return VehicleConfig::read_file(file);
}

}  // namespace

DemoPlan::DemoPlan(const DemoOptions& options) : options_(options), vehicle_(read_vehicle(options.vehicle)) {
  if (!options.record.empty() && std::filesystem::exists(options.record) &&
      !std::filesystem::is_empty(options.record))
    throw ConfigError("--record " + options.record +
                      ": the folder is not empty; allowed: a new or an empty one");
  url_ = bus_url_on_port(quiet_port(options.bus_port));
  constexpr auto kTimeToStart = std::chrono::seconds(1);
  start_ns_ = to_ns(WallClock::now() + MachineClock::slept() + kTimeToStart);
  // Beside what else is in the folder: what is started on the page gets a folder beside the first one.
  record_ = options.record.empty() ? work() / "recordings" / "drive"
                                   : std::filesystem::absolute(options.record).lexically_normal();
  if (!record_.has_filename()) record_ = record_.parent_path();
  std::ofstream file(vehicle_file(), std::ios::binary);
  file << vehicle_.text;
  if (!file.flush())
    throw std::system_error(errno, std::generic_category(), "write " + vehicle_file().string());
}

std::string DemoPlan::front_end_address() const {
  std::ostringstream address;
  address << options_.scenario << "?seed=" << options_.seed << "&rate=" << options_.rate
          << "&seconds=" << options_.drive_seconds;
  if (options_.rate != "max") address << "&start_ns=" << start_ns_;
  return address.str();
}

}  // namespace roadbalance
