#include "common/link/receiver.hpp"

#include <algorithm>

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kAckPeriod{200};
constexpr std::chrono::milliseconds kRepairPeriod{50};
constexpr std::chrono::milliseconds kEpochSilence{1000};
// Epochs and nodes beyond these are refused: nothing from the bus makes memory grow without limit.
constexpr std::size_t kMostPastEpochs = 1024;
constexpr std::size_t kMostNodes = 64;

}  // namespace

Receiver::Receiver(std::int64_t incarnation, ReceiverOptions options)
    : incarnation_(incarnation), options_(options) {}

void Receiver::recover(std::int32_t node, std::int64_t epoch, EpochPosition position) {
  nodes_[node].past[epoch] = position;
}

const EpochReceiver* Receiver::current(std::int32_t node) const {
  const auto found = nodes_.find(node);
  return found == nodes_.end() ? nullptr : found->second.epoch.get();
}

void Receiver::take(const SealedBlock& block, WallTime now, std::vector<Delivery>& out) {
  const auto refuse = [this](Refused why) { ++refused_[static_cast<std::size_t>(why)]; };
  if (block.header.sequence == 0) return refuse(Refused::kPreview);
  const auto found = nodes_.find(block.header.node);
  if (found == nodes_.end() || !found->second.epoch) return refuse(Refused::kUnknownEpoch);
  Node& node = found->second;
  if (node.epoch->epoch() != block.header.epoch)
    return refuse(node.past.contains(block.header.epoch) ? Refused::kClosedEpoch : Refused::kUnknownEpoch);
  switch (node.epoch->block(block, now, out)) {
    case EpochReceiver::Take::kAccepted:
      return;
    case EpochReceiver::Take::kDuplicate:
      return refuse(Refused::kDuplicate);
    case EpochReceiver::Take::kOutsideWindow:
      return refuse(Refused::kOutsideWindow);
  }
}

void Receiver::open_epoch(Node& node, const Heartbeat& heartbeat, std::vector<Delivery>& out) {
  EpochPosition start;
  if (const auto known = node.past.find(heartbeat.epoch); known != node.past.end()) {
    start = known->second;
    node.past.erase(known);
  }
  if (node.epoch) {
    node.epoch->crash(out);
    node.past[node.epoch->epoch()] = {.contiguous = node.epoch->received(), .ended = true};
  }
  // What an earlier run of this recorder left open of this node is over too.
  for (auto& [epoch, position] : node.past) {
    if (position.ended) continue;
    EpochReceiver open(heartbeat.node, epoch, position, {.window = 1});
    open.crash(out);
    position.ended = true;
  }
  node.epoch = std::make_unique<EpochReceiver>(heartbeat.node, heartbeat.epoch, start, options_);
  node.ack_number = 0;
  node.acked_durable = -1;
  node.acked_received = start.contiguous;
}

bool Receiver::may_open(const Node& node, const Heartbeat& heartbeat, WallTime now) {
  if (node.past.size() >= kMostPastEpochs) return false;
  const auto past = node.past.find(heartbeat.epoch);
  const bool is_over = heartbeat.state == NodeState::kEnded || heartbeat.state == NodeState::kFailed;
  if (!node.epoch) return past != node.past.end() || !is_over || heartbeat.base < heartbeat.next;
  if (past != node.past.end() && past->second.ended) return false;
  if (now - node.heard_at >= kEpochSilence) return true;
  ++rival_heartbeats_;
  return false;
}

void Receiver::take(const Heartbeat& heartbeat, WallTime now, std::vector<Delivery>& out) {
  if (!nodes_.contains(heartbeat.node) && nodes_.size() >= kMostNodes) return;
  Node& node = nodes_[heartbeat.node];
  if (!node.epoch || node.epoch->epoch() != heartbeat.epoch) {
    if (!may_open(node, heartbeat, now)) return;
    open_epoch(node, heartbeat, out);
  }
  node.heard_at = now;
  node.epoch->heartbeat(heartbeat, now, out);
}

void Receiver::durable(std::int32_t node, std::int64_t epoch, std::int64_t sequence) {
  const auto found = nodes_.find(node);
  if (found != nodes_.end() && found->second.epoch && found->second.epoch->epoch() == epoch)
    found->second.epoch->durable(sequence);
}

bool Receiver::is_due(const Node& node, WallTime now) const {
  const EpochReceiver& epoch = *node.epoch;
  const bool half_the_credit_is_used = epoch.received() - node.acked_received >= options_.window / 4;
  return epoch.durable() > node.acked_durable || half_the_credit_is_used ||
         now - node.acked_at >= (epoch.has_holes() ? kRepairPeriod : kAckPeriod);
}

std::vector<Ack> Receiver::due(WallTime now) {
  std::vector<Ack> acks;
  for (auto& [number, node] : nodes_) {
    if (!node.epoch || !is_due(node, now)) continue;
    const EpochReceiver& epoch = *node.epoch;
    node.acked_at = now;
    node.acked_durable = epoch.durable();
    node.acked_received = epoch.received();
    acks.push_back({.node = number,
                    .epoch = epoch.epoch(),
                    .incarnation = incarnation_,
                    .number = ++node.ack_number,
                    .received = epoch.received(),
                    .durable = epoch.durable(),
                    .credit = epoch.credit(),
                    .missing = node.epoch->missing(now)});
  }
  return acks;
}

}  // namespace roadbalance
