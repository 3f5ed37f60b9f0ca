#include "host/recorder/node_control.hpp"

#include <algorithm>

namespace roadbalance {
namespace {
constexpr std::chrono::milliseconds kRepeat{100};
constexpr Verb kNothing = Verb::kRelease;  // released only by farewell()
}  // namespace

NodeControl::NodeControl(std::int64_t incarnation, bool start, std::uint64_t seed)
    : incarnation_(incarnation), start_(start), random_(seed) {}

void NodeControl::take(const Heartbeat& heartbeat) {
  if (!nodes_.contains(heartbeat.node) && nodes_.size() >= kMostNodes) return;
  Node& node = nodes_[heartbeat.node];
  if (node.epoch != heartbeat.epoch) node = Node{.epoch = heartbeat.epoch};
  node.state = heartbeat.state;
  node.owned = heartbeat.owner == incarnation_;
  node.started = node.started || heartbeat.state != NodeState::kPreview;
  if (heartbeat.owner > incarnation_) obeyed_higher_ = std::max(obeyed_higher_, heartbeat.owner);
}

void NodeControl::take(const Reply& reply) {
  const auto found = nodes_.find(reply.node);
  if (found == nodes_.end() || found->second.request != reply.request || found->second.epoch != reply.epoch)
    return;
  Node& node = found->second;
  node.request = 0;  // the next one is a new request
  if (reply.result != CommandError::kNone) return;
  if (node.verb == Verb::kClaim) node.owned = true;
  if (node.verb == Verb::kStart) node.state = NodeState::kStarted;
}

void NodeControl::set_incarnation(std::int64_t incarnation) {
  incarnation_ = incarnation;
  obeyed_higher_ = 0;
  for (auto& [number, node] : nodes_) {
    node.owned = false;
    node.request = 0;
  }
}

Verb NodeControl::wanted(const Node& node) const {
  if (!node.owned) return Verb::kClaim;
  if (!stopping_ && start_ && node.state == NodeState::kPreview) return Verb::kStart;
  // A node that was sent a start may get it only now: a stop behind it makes sure.
  const bool has_ended = node.state == NodeState::kEnded || node.state == NodeState::kFailed;
  if (stopping_ && node.started && !has_ended) return Verb::kStop;
  return kNothing;
}

Command NodeControl::command(std::int32_t number, const Node& node) const {
  return {.node = number, .request = node.request, .incarnation = incarnation_, .verb = node.verb};
}

std::vector<Command> NodeControl::due(WallTime now) {
  std::vector<Command> commands;
  for (auto& [number, node] : nodes_) {
    const Verb verb = wanted(node);
    if (verb == kNothing) continue;
    if (verb != node.verb || node.request == 0) {
      const bool same_again = verb == node.verb && now - node.sent_at < kRepeat;
      if (same_again) continue;
      node.verb = verb;
      node.request = static_cast<std::int64_t>(random_() >> 1) | 1;
    } else if (now - node.sent_at < kRepeat) {
      continue;
    }
    node.sent_at = now;
    node.started = node.started || verb == Verb::kStart;
    commands.push_back(command(number, node));
  }
  return commands;
}

std::vector<Command> NodeControl::farewell() {
  std::vector<Command> commands;
  for (auto& [number, node] : nodes_) {
    if (!node.owned) continue;
    node.verb = Verb::kRelease;
    node.request = static_cast<std::int64_t>(random_() >> 1) | 1;
    commands.push_back(command(number, node));
  }
  return commands;
}

bool NodeControl::was_started(std::int32_t node) const {
  const auto found = nodes_.find(node);
  return found != nodes_.end() && found->second.started;
}

}  // namespace roadbalance
