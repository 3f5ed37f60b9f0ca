#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/frontend/front_end.hpp"
#include "common/frontend/side_source.hpp"

namespace roadbalance {

/// The arguments a front end is opened with: the address, e.g. "sim:scenario.toml?seed=7&rate=20", the
/// vehicle and which of its nodes this is.
struct FrontEndRequest {
  std::string address;  ///< what follows "scheme:"
  const VehicleConfig& vehicle;
  const NodeConfig& node;
};

/// A device gives scans, or what belongs beside the scans of another.
using OpenedDevice = std::variant<std::unique_ptr<FrontEnd>, std::unique_ptr<SideSource>>;

/// Devices by URI scheme.  Each program's main registers what it offers.
class FrontEndRegistry {
 public:
  using Open = std::function<OpenedDevice(const FrontEndRequest&)>;

  void add(std::string scheme, Open open);

  /// @param uri  "scheme:address"
  /// @throws ConfigError naming the URI and the schemes there are, or if the device gives no scans; or what
  ///         the backend throws
  std::unique_ptr<FrontEnd> open(const std::string& uri, const VehicleConfig& vehicle,
                                 const NodeConfig& node) const;

  /// Several devices as one front end: exactly one that gives scans, any number that give what is beside.
  /// @throws as open()
  std::unique_ptr<FrontEnd> open(const std::vector<std::string>& uris, const VehicleConfig& vehicle,
                                 const NodeConfig& node) const;

  /// One of them.  @throws as open()
  OpenedDevice open_device(const std::string& uri, const VehicleConfig& vehicle,
                           const NodeConfig& node) const;

 private:
  std::map<std::string, Open> schemes_;
};

}  // namespace roadbalance
