#include "tools/rb/demo_plan.hpp"

#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <system_error>

#include "common/bus/bus.hpp"
#include "common/clock/clocks.hpp"
#include "common/config/section.hpp"
#include "embedded/demo_vehicle.hpp"
#include "sim/address.hpp"

namespace roadbalance {
namespace {

std::filesystem::path make_work_folder() {
  std::string name = (std::filesystem::temp_directory_path() / "rb-demo-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr)
    throw std::system_error(errno, std::generic_category(), "create " + name);
  return name;
}

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
  url_ = bus_url_on_port(options.port != 0 ? options.port : 20'000 + getpid() % 20'000);
  constexpr auto kTimeToStart = std::chrono::seconds(1);
  start_ns_ = std::chrono::nanoseconds((WallClock::now() + kTimeToStart).time_since_epoch()).count();
  sim::Address::parse(front_end_address());  // a wrong rate is said now and here
  work_ = make_work_folder();
  record_ = options.record.empty() ? work_ / "record" : std::filesystem::path(options.record);
  std::ofstream file(vehicle_file(), std::ios::binary);
  file << vehicle_.text;
  if (!file.flush())
    throw std::system_error(errno, std::generic_category(), "write " + vehicle_file().string());
}

DemoPlan::~DemoPlan() {
  std::error_code ignored;  // a temporary folder that stays hurts nobody
  std::filesystem::remove_all(work_, ignored);
}

std::string DemoPlan::front_end_address() const {
  std::ostringstream address;
  address << options_.scenario << "?seed=" << options_.seed << "&rate=" << options_.rate
          << "&seconds=" << options_.drive_seconds;
  if (options_.rate != "max") address << "&start_ns=" << start_ns_;
  return address.str();
}

}  // namespace roadbalance
