#include "common/link/receiver.hpp"

#include <algorithm>

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kAckPeriod{200};
constexpr std::chrono::milliseconds kRepairPeriod{50};
constexpr std::chrono::milliseconds kEpochSilence{1000};
// Nothing from the bus makes memory grow without limit: of more epochs of a node the oldest are forgotten.
constexpr std::size_t kMostPastEpochs = 1024;
// Of an epoch that is over, one every kAckPeriod: nobody says whether an ack was heard.
constexpr int kLastAcks = 5;

}  // namespace

Receiver::Receiver(std::int64_t incarnation, ReceiverOptions options)
    : incarnation_(incarnation), options_(options) {}

void Receiver::recover(std::int32_t node, std::int64_t epoch, EpochPosition position) {
  nodes_[node].past.push_back({.epoch = epoch, .position = position});
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
    return refuse(find_past(node, block.header.epoch) ? Refused::kClosedEpoch : Refused::kUnknownEpoch);
  switch (node.epoch->block(block, now, out)) {
    case EpochReceiver::Take::kAccepted:
      return;
    case EpochReceiver::Take::kDuplicate:
      return refuse(Refused::kDuplicate);
    case EpochReceiver::Take::kOutsideWindow:
      return refuse(Refused::kOutsideWindow);
  }
}

Receiver::Past* Receiver::find_past(Node& node, std::int64_t epoch) {
  const auto found =
      std::find_if(node.past.begin(), node.past.end(), [&](const Past& past) { return past.epoch == epoch; });
  return found == node.past.end() ? nullptr : &*found;
}

void Receiver::close(Past& past, const EpochReceiver& epoch) {
  past.position.contiguous = epoch.received();
  past.position.ended = true;
  past.durable = epoch.durable();
  past.acks_left = kLastAcks;
}

void Receiver::open_epoch(Node& node, const Heartbeat& heartbeat, std::vector<Delivery>& out) {
  EpochPosition start;
  if (const Past* known = find_past(node, heartbeat.epoch)) {
    start = known->position;
    node.past.erase(node.past.begin() + (known - node.past.data()));
  }
  // What an earlier run of this recorder left open of this node is over too.
  for (Past& past : node.past) {
    if (past.position.ended) continue;
    EpochReceiver open(heartbeat.node, past.epoch, past.position, {.window = 1});
    open.crash(out);
    close(past, open);
  }
  if (node.epoch) {
    node.epoch->crash(out);
    close(node.past.emplace_back(Past{.epoch = node.epoch->epoch(), .position = {}}), *node.epoch);
  }
  if (node.past.size() > kMostPastEpochs) node.past.erase(node.past.begin());
  node.epoch = std::make_unique<EpochReceiver>(heartbeat.node, heartbeat.epoch, start, options_);
  node.ack_number = 0;
  node.acked_durable = -1;
  node.acked_received = start.contiguous;
}

bool Receiver::may_open(Node& node, const Heartbeat& heartbeat, WallTime now) {
  const Past* past = find_past(node, heartbeat.epoch);
  const bool is_over = heartbeat.state == NodeState::kEnded || heartbeat.state == NodeState::kFailed;
  if (!node.epoch) return past || !is_over || heartbeat.base < heartbeat.next;
  if (past && past->position.ended) return false;
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
  if (found == nodes_.end()) return;
  if (found->second.epoch && found->second.epoch->epoch() == epoch)
    found->second.epoch->durable(sequence);
  else if (Past* past = find_past(found->second, epoch))
    past->durable = std::max(past->durable, std::min(sequence, past->position.contiguous));
}

bool Receiver::is_due(const Node& node, WallTime now) const {
  const EpochReceiver& epoch = *node.epoch;
  const bool much_credit_is_used = epoch.received() - node.acked_received >= options_.window / 4;
  return epoch.durable() > node.acked_durable || much_credit_is_used ||
         now - node.acked_at >= (epoch.has_holes() ? kRepairPeriod : kAckPeriod);
}

// The node of a closed epoch is gone; others wait to hear that its last blocks are durable.
void Receiver::acknowledge_past(std::int32_t number, Node& node, WallTime now, std::vector<Ack>& acks) const {
  for (Past& past : node.past) {
    const std::int64_t last = past.position.contiguous;
    if (past.acks_left == 0 || past.durable < last || now - past.acked_at < kAckPeriod) continue;
    --past.acks_left;
    past.acked_at = now;
    acks.push_back({.node = number,
                    .epoch = past.epoch,
                    .incarnation = incarnation_,
                    .number = ++node.ack_number,
                    .received = last,
                    .durable = last,
                    .credit = last,
                    .missing = {}});
  }
}

std::vector<Ack> Receiver::due(WallTime now) {
  std::vector<Ack> acks;
  for (auto& [number, node] : nodes_) {
    acknowledge_past(number, node, now, acks);
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
