#include "common/frontend/registry.hpp"

#include <utility>

#include "common/config/section.hpp"

namespace roadbalance {

void FrontEndRegistry::add(std::string scheme, Open open) {
  schemes_.insert_or_assign(std::move(scheme), std::move(open));
}

std::unique_ptr<FrontEnd> FrontEndRegistry::open(const std::string& uri, const VehicleConfig& vehicle,
                                                 const NodeConfig& node) const {
  const auto colon = uri.find(':');
  const auto found = colon == std::string::npos ? schemes_.end() : schemes_.find(uri.substr(0, colon));
  if (found == schemes_.end()) {
    std::string known;
    for (const auto& [scheme, unused] : schemes_) known += (known.empty() ? "" : ", ") + scheme + ":";
    throw ConfigError("front end \"" + uri + "\": no such kind of front end; allowed: " + known);
  }
  return found->second({uri.substr(colon + 1), vehicle, node});
}

}  // namespace roadbalance
