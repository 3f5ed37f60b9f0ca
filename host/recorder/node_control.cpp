#include "host/recorder/node_control.hpp"

#include <algorithm>
#include <utility>

namespace roadbalance {
namespace {
using std::chrono::milliseconds;
constexpr milliseconds kRepeat{100};
constexpr int kTries = 12;              // of an announcement
constexpr milliseconds kOwnNotice{60};  // of a node that comes when the common start is over, or all but
constexpr std::chrono::seconds kControlSilence{3};
// A number from the bus that is higher still is no recorder's: one above it, and above that at each later
// start, must remain an incarnation.
constexpr std::int64_t kHighestObeyed = kIndexLimit - (1 << 20);
constexpr Verb kNothing = Verb::kRelease;  // released only by farewell()
}  // namespace

NodeControl::NodeControl(std::int64_t incarnation, bool start, std::uint64_t seed, bool ends_previews,
                         milliseconds notice)
    : incarnation_(incarnation),
      start_(start),
      ends_previews_(ends_previews),
      notice_(notice),
      random_(seed) {}

milliseconds NodeControl::notice_for(std::size_t nodes) {
  constexpr std::size_t kFew = 8;
  return milliseconds(150) + milliseconds(10) * (std::max(nodes, kFew) - kFew);
}

void NodeControl::take(const Heartbeat& heartbeat) {
  const Key key{heartbeat.node, heartbeat.epoch};
  if (!nodes_.contains(key) && nodes_.size() >= kMostEpochs)
    nodes_.erase(std::min_element(nodes_.begin(), nodes_.end(), [](const auto& a, const auto& b) {
      return a.second.heard < b.second.heard;
    }));
  Node& node = nodes_[key];
  node.heard = ++heartbeats_;
  node.state = heartbeat.state;
  node.is_start_answered = false;
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
  if (reply.result == CommandError::kNotOwner && node.verb == Verb::kClaim) {
    note_obeyed(reply.sequence);
    node.start_at.reset();  // it was another's when the start was announced
  }
  if (reply.result != CommandError::kNone) return;
  if (node.verb == Verb::kClaim) node.owned = node.obeyed = true;
  if (node.verb == Verb::kStart) node.is_start_answered = true;
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

Verb NodeControl::wanted(const Node& node, WallTime now) const {
  if (!node.owned) return Verb::kClaim;
  if (!stopping_ && start_ && node.state == NodeState::kPreview &&
      (!node.is_start_answered || announces(node, now)))
    return Verb::kStart;
  // A node that was sent a start may get it only now: a stop behind it makes sure.
  const bool has_ended = node.state == NodeState::kEnded || node.state == NodeState::kFailed;
  if (stopping_ && node.started && !has_ended) return Verb::kStop;
  return kNothing;
}

// Its start is still to come.
bool NodeControl::announces(const Node& node, WallTime now) const {
  return node.start_at && now < *node.start_at;
}

void NodeControl::appoint(WallTime now) {
  if (start_ && !start_at_ && !nodes_.empty()) {
    start_at_ = now + notice_;
    for (auto& [key, node] : nodes_) node.start_at = start_at_;
  }
  if (!stopping_ || stop_at_) return;
  if (start_) stop_notice_ = notice_for(nodes_.size());
  stop_at_ = now + stop_notice_;
}

Command NodeControl::command(const Key& key, const Node& node, WallTime now) const {
  std::optional<WallTime> instant;
  if (node.verb == Verb::kStart) instant = node.start_at;
  if (node.verb == Verb::kStop) instant = stop_at_;
  const auto delay = std::chrono::duration_cast<std::chrono::microseconds>(instant.value_or(now) - now);
  return {.node = key.first,
          .request = node.request,
          .incarnation = incarnation_,
          .verb = node.verb,
          .epoch = key.second,
          .delay_us = std::clamp<std::int64_t>(delay.count(), -kLongestDelay_us, kLongestDelay_us)};
}

milliseconds NodeControl::repeats_after(const Node& node, Verb verb, WallTime now) const {
  if (verb == Verb::kStop) return now < *stop_at_ ? stop_notice_ / kTries : kRepeat;
  if (!announces(node, now)) return kRepeat;
  return (node.start_at == start_at_ ? notice_ : kOwnNotice) / kTries;
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
  appoint(now);
  for (auto& [key, node] : nodes_) {
    const Verb verb = wanted(node, now);
    if (verb == Verb::kStart && !node.start_at) node.start_at = std::max(*start_at_, now + kOwnNotice);
    if (is_silent(node, now) || verb == kNothing) continue;
    const bool waits = now - node.sent_at < repeats_after(node, verb, now);
    if (verb != node.verb || node.request == 0) {
      if (verb == node.verb && waits) continue;
      node.verb = verb;
      node.request = new_request();
    } else if (waits) {
      continue;
    }
    node.sent_at = now;
    node.started = node.started || verb == Verb::kStart;
    commands.push_back(command(key, node, now));
  }
  return commands;
}

std::vector<Command> NodeControl::farewell() {
  std::vector<Command> commands;
  for (auto& [key, node] : nodes_) {
    if (!node.owned) continue;
    node.verb = Verb::kRelease;
    node.request = new_request();
    commands.push_back(command(key, node, {}));
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
