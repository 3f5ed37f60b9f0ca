#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "common/config/vehicle_config.hpp"
#include "common/frontend/front_end.hpp"

namespace roadbalance {

/// What a front end is opened with: the address, e.g. "sim:scenario.toml?seed=7&rate=20", the vehicle
/// and which of its nodes this is.
struct FrontEndRequest {
  std::string address;  ///< what follows "scheme:"
  const VehicleConfig& vehicle;
  const NodeConfig& node;
};

/// Front ends by URI scheme.  Each program's main registers what it offers.
class FrontEndRegistry {
 public:
  using Open = std::function<std::unique_ptr<FrontEnd>(const FrontEndRequest&)>;

  void add(std::string scheme, Open open);

  /// @param uri  "scheme:address"
  /// @throws ConfigError naming the URI and the schemes there are, or what the backend throws
  std::unique_ptr<FrontEnd> open(const std::string& uri, const VehicleConfig& vehicle,
                                 const NodeConfig& node) const;

 private:
  std::map<std::string, Open> schemes_;
};

}  // namespace roadbalance
