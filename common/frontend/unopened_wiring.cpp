#include "common/frontend/unopened_wiring.hpp"

#include <algorithm>

namespace roadbalance {

std::vector<std::string> unopened_wiring(const NodeConfig& node, const std::vector<std::string>& uris) {
  const auto any_begins = [&](const std::string& with) {
    return std::ranges::any_of(uris, [&](const std::string& uri) { return uri.starts_with(with); });
  };
  if (any_begins("sim:") || any_begins("replay:")) return {};
  std::vector<std::string> sentences;
  const std::string name = "node " + node.name + ": ";
  if (!any_begins("gpio:"))
    for (const LineConfig& line : node.wiring.line)
      sentences.push_back(name + "[[node.line]] wires the encoder of line " + std::to_string(line.line) +
                          " to GPIO, but no gpio: is among its front ends: its angle stays unknown");
  for (const CanConfig& can : node.wiring.can) {
    if (std::ranges::find(uris, "can:" + can.interface) != uris.end()) continue;
    sentences.push_back(name + "[[node.can]] describes " + can.interface + ", but no can:" + can.interface +
                        " is among its front ends: what comes there is not recorded");
  }
  return sentences;
}

}  // namespace roadbalance
