#include "host/recorder/node_control.hpp"

#include <algorithm>
#include <utility>

namespace roadbalance {
namespace {
constexpr std::chrono::milliseconds kRepeat{100};
constexpr std::chrono::seconds kControlSilence{3};
// A number from the bus that is higher still is no recorder's: one above it, and above that at each later
// start, must remain an incarnation.
constexpr std::int64_t kHighestObeyed = kIndexLimit - (1 << 20);
constexpr Verb kNothing = Verb::kRelease;  // released only by farewell()
}  // namespace

NodeControl::NodeControl(std::int64_t incarnation, bool start, std::uint64_t seed, bool ends_previews)
    : incarnation_(incarnation), start_(start), ends_previews_(ends_previews), random_(seed) {}

void NodeControl::take(const Heartbeat& heartbeat) {
  const Key key{heartbeat.node, heartbeat.epoch};
  if (!nodes_.contains(key) && nodes_.size() >= kMostEpochs)
    nodes_.erase(std::min_element(nodes_.begin(), nodes_.end(), [](const auto& a, const auto& b) {
      return a.second.heard < b.second.heard;
    }));
  Node& node = nodes_[key];
  node.heard = ++heartbeats_;
  node.state = heartbeat.state;
  node.owned = heartbeat.owner == incarnation_;
  node.obeyed = node.obeyed || node.owned;
  node.heard_so = node.heard_so || node.owned;
  node.started = node.started || ends_previews_ || heartbeat.state != NodeState::kPreview;
  note_obeyed(heartbeat.owner);
}

void NodeControl::take(const Reply& reply) {
  const auto found = nodes_.find({reply.node, reply.epoch});
  if (found == nodes_.end() || found->second.request != reply.request || reply.request == 0) return;
  Node& node = found->second;
  node.request = 0;  // the next one is a new request
  if (reply.result == CommandError::kNotOwner && node.verb == Verb::kClaim) note_obeyed(reply.sequence);
  if (reply.result != CommandError::kNone) return;
  if (node.verb == Verb::kClaim) node.owned = node.obeyed = true;
  if (node.verb == Verb::kStart) node.state = NodeState::kStarted;
}

void NodeControl::note_obeyed(std::int64_t incarnation) {
  if (incarnation > incarnation_ && incarnation <= kHighestObeyed)
    obeyed_higher_ = std::max(obeyed_higher_, incarnation);
}

void NodeControl::set_incarnation(std::int64_t incarnation) {
  incarnation_ = incarnation;
  obeyed_higher_ = 0;
  for (auto& [key, node] : nodes_) {
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

Command NodeControl::command(const Key& key, const Node& node) const {
  return {.node = key.first,
          .request = node.request,
          .incarnation = incarnation_,
          .verb = node.verb,
          .epoch = key.second};
}

std::int64_t NodeControl::new_request() {
  return static_cast<std::int64_t>(random_() >> 1) | 1;
}

// Heartbeats bear no time of ours: one counts from the first look after it.
bool NodeControl::is_silent(Node& node, WallTime now) const {
  if (std::exchange(node.seen, node.heard) != node.heard) node.heard_at = now;
  return now - node.heard_at > kControlSilence;
}

std::vector<Command> NodeControl::due(WallTime now) {
  std::vector<Command> commands;
  for (auto& [key, node] : nodes_) {
    const Verb verb = wanted(node);
    if (is_silent(node, now) || verb == kNothing) continue;
    const bool waits = now - node.sent_at < kRepeat;
    if (verb != node.verb || node.request == 0) {
      if (verb == node.verb && waits) continue;
      node.verb = verb;
      node.request = new_request();
    } else if (waits) {
      continue;
    }
    node.sent_at = now;
    node.started = node.started || verb == Verb::kStart;
    commands.push_back(command(key, node));
  }
  return commands;
}

std::vector<Command> NodeControl::farewell() {
  std::vector<Command> commands;
  for (auto& [key, node] : nodes_) {
    if (!node.owned) continue;
    node.verb = Verb::kRelease;
    node.request = new_request();
    commands.push_back(command(key, node));
  }
  return commands;
}

bool NodeControl::was_started(std::int32_t node, std::int64_t epoch) const {
  const auto found = nodes_.find({node, epoch});
  return found != nodes_.end() && found->second.is_ours_to_end();
}

bool NodeControl::has_obeyed(std::int32_t node, std::int64_t epoch) const {
  const auto found = nodes_.find({node, epoch});
  return found != nodes_.end() && found->second.obeyed;
}

bool NodeControl::is_asking(WallTime now) const {
  return std::any_of(nodes_.begin(), nodes_.end(), [now](const auto& known) {
    const Node& node = known.second;
    const bool is_heard = node.seen != node.heard || now - node.heard_at <= kControlSilence;
    return node.started && !node.heard_so && is_heard;
  });
}

bool NodeControl::is_owned(std::int32_t node, std::int64_t epoch) const {
  const auto found = nodes_.find({node, epoch});
  return found != nodes_.end() && found->second.owned;
}

}  // namespace roadbalance
