#include "host/recorder/heard_epochs.hpp"

#include <algorithm>

namespace roadbalance {
namespace {

// At the end the last acks are repeated until each node has heard that all is durable, or is silent.
constexpr std::chrono::milliseconds kNodeSilence{12'000};
constexpr std::chrono::milliseconds kEpochGone{1000};

}  // namespace

void HeardEpochs::was_held(WallTime::duration held) {
  for (auto& [key, heard] : heard_) heard.at += held;
}

// No more are kept than the receiver has epochs.
void HeardEpochs::take(const Heartbeat& heartbeat, WallTime now, bool wants_notes,
                       std::vector<DeviceNote>& notes) {
  const NodeEpoch key{heartbeat.node, heartbeat.epoch};
  if (!heard_.contains(key))
    std::erase_if(heard_,
                  [this](const auto& old) { return !receiver_.find(old.first.first, old.first.second); });
  Heard& heard = heard_[key];
  heard.at = now;
  heard.base = heartbeat.base;
  heard.next = heartbeat.next;
  heard.devices.take(heartbeat.device_counts);
  if (wants_notes) heard.devices.due(heartbeat.node, now, notes);
}

void HeardEpochs::finish(std::vector<DeviceNote>& notes) {
  for (auto& [key, heard] : heard_) heard.devices.finish(key.first, notes);
}

// Its last heartbeat may be from before its last blocks: a node that has sent these and was held since keeps
// them until it hears that they are durable, and the next recording would take them for its own.
bool HeardEpochs::holds_blocks(NodeEpoch key) const {
  const auto heard = heard_.find(key);
  if (heard == heard_.end()) return false;
  const auto* epoch = receiver_.find(key.first, key.second);
  const bool is_its_own = epoch && !epoch->given_up();  // and not a crash that was declared for it
  const std::int64_t next = std::max(heard->second.next, is_its_own ? epoch->received() + 1 : 0);
  return heard->second.base < next;
}

bool HeardEpochs::has_ended(NodeEpoch key) const {
  const auto* epoch = receiver_.find(key.first, key.second);
  return !epoch || (epoch->ended() && epoch->durable() == epoch->received());
}

bool HeardEpochs::has_let_go(NodeEpoch key) const {
  return heard_.contains(key) && has_ended(key) && !holds_blocks(key);
}

// It is silent, and a later epoch of the node was heard: nothing of it is waited for.
bool HeardEpochs::is_superseded(NodeEpoch key, WallTime now) const {
  const WallTime at = heard_.at(key).at;
  return now - at >= kEpochGone && std::any_of(heard_.begin(), heard_.end(), [&](const auto& other) {
           return other.first.first == key.first && other.second.at > at;
         });
}

bool HeardEpochs::all_ended(WallTime now) const {
  return std::all_of(heard_.begin(), heard_.end(), [&](const auto& heard) {
    const auto& [node, epoch] = heard.first;
    return is_superseded(heard.first, now) || !control_.was_started(node, epoch) || has_ended(heard.first);
  });
}

bool HeardEpochs::have_ended(const std::vector<std::int32_t>& nodes, WallTime now) const {
  return std::all_of(nodes.begin(), nodes.end(), [&](std::int32_t node) {
    bool was_heard = false;
    for (const auto& [key, heard] : heard_) {
      if (key.first != node || is_superseded(key, now)) continue;
      if (!has_ended(key)) return false;
      was_heard = true;
    }
    return was_heard;
  });
}

bool HeardEpochs::all_have_let_go(WallTime now) const {
  return std::all_of(heard_.begin(), heard_.end(), [&](const auto& heard) {
    const auto& [key, last] = heard;
    return !has_ended(key) || !holds_blocks(key) || now - last.at >= kNodeSilence;
  });
}

}  // namespace roadbalance
