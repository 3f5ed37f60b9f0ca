#include "common/frontend/registry.hpp"

#include <utility>

#include "common/config/section.hpp"
#include "common/frontend/mixed_front_end.hpp"

namespace roadbalance {

void FrontEndRegistry::add(std::string scheme, Open open) {
  schemes_.insert_or_assign(std::move(scheme), std::move(open));
}

OpenedDevice FrontEndRegistry::open_device(const std::string& uri, const VehicleConfig& vehicle,
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

std::unique_ptr<FrontEnd> FrontEndRegistry::open(const std::string& uri, const VehicleConfig& vehicle,
                                                 const NodeConfig& node) const {
  return open(std::vector{uri}, vehicle, node);
}

std::unique_ptr<FrontEnd> FrontEndRegistry::open(const std::vector<std::string>& uris,
                                                 const VehicleConfig& vehicle, const NodeConfig& node) const {
  std::unique_ptr<FrontEnd> scans;
  std::string scans_uri, all;
  std::vector<std::unique_ptr<SideSource>> sides;
  for (const std::string& uri : uris) {
    OpenedDevice device = open_device(uri, vehicle, node);
    all += (all.empty() ? "" : ", ") + uri;
    if (auto* const side = std::get_if<std::unique_ptr<SideSource>>(&device)) {
      sides.push_back(std::move(*side));
      continue;
    }
    if (scans)
      throw ConfigError("front ends " + scans_uri + " and " + uri +
                        ": both give scans; allowed: one that does");
    scans_uri = uri;
    scans = std::get<std::unique_ptr<FrontEnd>>(std::move(device));
  }
  if (!scans)
    throw ConfigError("node " + node.name + ": " +
                      (all.empty() ? "no front end" : "no scans come from " + all) +
                      "; allowed: one device that gives them, e.g. usb:1209:0001 or sim:");
  if (sides.empty()) return scans;
  return std::make_unique<MixedFrontEnd>(std::move(scans), std::move(sides), node.rate_hz);
}

}  // namespace roadbalance
