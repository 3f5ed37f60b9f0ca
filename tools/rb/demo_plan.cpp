#include "tools/rb/demo_plan.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <system_error>

#include "common/bus/bus.hpp"
#include "common/config/section.hpp"
#include "embedded/demo_vehicle.hpp"

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

std::string DemoPlan::front_end() const {
  std::ostringstream uri;
  uri << "sim:" << options_.scenario << "?seed=" << options_.seed << "&rate=" << options_.rate
      << "&seconds=" << options_.drive_seconds;
  return uri.str();
}

}  // namespace roadbalance
