#include "host/recorder/foreign_nodes.hpp"

namespace roadbalance {

void ForeignNodes::take(const Heartbeat& heartbeat, std::int64_t our_incarnation, WallTime now) {
  const std::string name = "node " + std::to_string(heartbeat.node);
  const auto known = nodes_.find(heartbeat.node);
  if (heartbeat.owner == 0 || heartbeat.owner == our_incarnation) {
    if (known == nodes_.end()) return;
    if (known->second.told && heartbeat.owner != 0) sentences_.push_back(name + " obeys this recorder now");
    nodes_.erase(known);
    return;
  }
  if (known == nodes_.end()) {
    if (nodes_.size() < kMostNodes) nodes_[heartbeat.node] = {.since = now, .heard = now};
    return;
  }
  Node& node = known->second;
  if (now - std::exchange(node.heard, now) >= kPatience) node.since = now;  // nobody knows what was between
  if (node.told || now - node.since < kPatience) return;
  node.told = true;
  sentences_.push_back(name + " obeys another recorder (incarnation " + std::to_string(heartbeat.owner) +
                       "): only observed here until that one is silent or lets it go");
}

std::vector<std::int32_t> ForeignNodes::nodes() const {
  std::vector<std::int32_t> numbers;
  for (const auto& [number, node] : nodes_)
    if (node.told) numbers.push_back(number);
  return numbers;
}

}  // namespace roadbalance
