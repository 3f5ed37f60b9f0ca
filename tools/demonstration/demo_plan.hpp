#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/config/vehicle_config.hpp"
#include "common/process/temporary_folder.hpp"

namespace roadbalance {

/// Options of rb demo.
struct DemoOptions {
  std::uint64_t seed = 1;
  double drive_seconds = 320.0;
  std::string rate = "20";  ///< times real time, or "max"
  std::string record;       ///< empty: a temporary folder
  std::string vehicle;      ///< empty: the demo's own
  std::string scenario;     ///< empty: the demo's own
  int port = 0;             ///< of the page; 0: a free one
  int bus_port = 0;         ///< 0: a free one
  bool headless = false;
  bool json = false;
  bool threads = false;
};

/// Everything settled before anything starts.  Its temporary folder is removed with it.
class DemoPlan {
 public:
  /// @throws ConfigError if vehicle or scenario cannot be used, or if the record folder already holds a
  /// recording; std::runtime_error if another program is on the port; std::system_error for files
  explicit DemoPlan(const DemoOptions& options);

  const VehicleConfig& vehicle() const { return vehicle_; }
  const std::string& url() const { return url_; }
  const std::filesystem::path& record() const { return record_; }
  /// Where that and those started on the page lie.
  std::filesystem::path recordings() const { return record_.parent_path(); }
  bool has_page() const { return !options_.headless; }
  /// Logs of the programs, and the vehicle file the nodes read.  Nothing else of it reaches recorder or
  /// analyser.
  const std::filesystem::path& work() const { return work_.path(); }
  std::filesystem::path vehicle_file() const { return work() / "vehicle.toml"; }
  int page_port() const { return options_.port; }  ///< 0: a free one
  /// The nodes' front end: "sim:PATH?seed=...", and the same without the scheme.
  std::string front_end() const { return "sim:" + front_end_address(); }
  std::string front_end_address() const;

 private:
  DemoOptions options_;
  TemporaryFolder work_{"rb-demo"};
  std::filesystem::path record_;
  std::string url_;
  std::int64_t start_ns_;  ///< of the drive, CLOCK_BOOTTIME: one start for all nodes
  VehicleConfig vehicle_;
};

}  // namespace roadbalance
