#include "common/link/receiver.hpp"

#include <algorithm>
#include <utility>

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kAckPeriod{200};
constexpr std::chrono::milliseconds kRepeatPeriod{40};
// While blocks are to be asked for.  The sender does not answer twice within twice this time.
constexpr std::chrono::milliseconds kAskPeriod{5};
constexpr std::chrono::milliseconds kEpochSilence{1000};
constexpr std::chrono::milliseconds kLongSilence{10'000};
// Nothing from the bus makes memory grow without limit: of more epochs of a node the oldest are forgotten.
constexpr std::size_t kMostPastEpochs = 1024;
// For an epoch that is over, one every kAckPeriod: nothing shows whether an ack arrived.
constexpr int kLastAcks = 5;

}  // namespace

Receiver::Receiver(std::int64_t incarnation, ReceiverOptions options)
    : incarnation_(incarnation), options_(options) {}

void Receiver::recover(std::int32_t node, std::int64_t epoch, EpochPosition position) {
  nodes_[node].past.push_back({.epoch = epoch, .position = position, .superseded_at = {}});
}

const EpochReceiver* Receiver::find(std::int32_t node, std::int64_t epoch) const {
  const auto found = nodes_.find(node);
  if (found == nodes_.end()) return nullptr;
  for (const Live& live : found->second.live)
    if (live.receiver->epoch() == epoch) return live.receiver.get();
  return nullptr;
}

std::size_t Receiver::live_in_all() const {
  std::size_t count = 0;
  for (const auto& [number, node] : nodes_) count += node.live.size();
  return count;
}

Receiver::Live* Receiver::find_live(Node& node, std::int64_t epoch) {
  for (Live& live : node.live)
    if (live.receiver->epoch() == epoch) return &live;
  return nullptr;
}

Receiver::Past* Receiver::find_past(Node& node, std::int64_t epoch) {
  for (Past& past : node.past)
    if (past.epoch == epoch) return &past;
  return nullptr;
}

void Receiver::take(const SealedBlock& block, WallTime now, std::vector<Delivery>& out) {
  const auto refuse = [this](Refused why) { ++refused_[static_cast<std::size_t>(why)]; };
  if (block.header.sequence == 0) return refuse(Refused::kPreview);
  const auto found = nodes_.find(block.header.node);
  if (found == nodes_.end()) return refuse(Refused::kUnknownEpoch);
  Live* const live = find_live(found->second, block.header.epoch);
  if (!live)
    return refuse(find_past(found->second, block.header.epoch) ? Refused::kClosedEpoch
                                                               : Refused::kUnknownEpoch);
  switch (live->receiver->block(block, now, out)) {
    case EpochReceiver::Take::kAccepted:
      return;
    case EpochReceiver::Take::kDuplicate:
      return refuse(Refused::kDuplicate);
    case EpochReceiver::Take::kOutsideWindow:
      return refuse(live->receiver->given_up() ? Refused::kClosedEpoch : Refused::kOutsideWindow);
  }
}

void Receiver::take(const Heartbeat& heartbeat, WallTime now, std::vector<Delivery>& out) {
  if (!nodes_.contains(heartbeat.node) && nodes_.size() >= kMostNodes) return;
  if (!began_at_) began_at_ = now;
  Node& node = nodes_[heartbeat.node];
  Live* live = find_live(node, heartbeat.epoch);
  if (!live) {
    if (!may_open(node, heartbeat, now, out)) return;
    EpochPosition start;
    if (const Past* known = find_past(node, heartbeat.epoch)) {
      start = known->position;
      node.past.erase(node.past.begin() + (known - node.past.data()));
    }
    live = &open(node, heartbeat.node, heartbeat.epoch, start);
  } else if (live->receiver->given_up()) {
    if (heartbeat.base < heartbeat.next) ++rival_heartbeats_;
    return;
  }
  note_rivals(node, *live);
  live->heard_at = now;
  live->base = heartbeat.base;
  live->next = heartbeat.next;
  live->receiver->heartbeat(heartbeat, now, out);
  close_silent(node, heartbeat.node, heartbeat.epoch, now, out);
}

bool Receiver::may_open(Node& node, const Heartbeat& heartbeat, WallTime now, std::vector<Delivery>& out) {
  const Past* past = find_past(node, heartbeat.epoch);
  const bool holds_blocks = heartbeat.base < heartbeat.next;
  // A node that died by our own account, and yet lives: its blocks have no place in the record any more.
  if (past && past->position.crashed) {
    if (holds_blocks) ++rival_heartbeats_;
    return false;
  }
  // From an epoch that is over the receiver wants the blocks it still has, or its node the word that they are
  // here.
  if (heartbeat.is_over() && !holds_blocks && (!past || past->position.ended)) return false;
  return make_room(node, now, out);
}

// For one more epoch: those that are over and on the disk go first, then the one that is silent longest. An
// epoch that is over but not on the disk stays: when a past epoch is received again, all of it counts as
// durable.
bool Receiver::make_room(Node& node, WallTime now, std::vector<Delivery>& out) {
  if (node.live.size() < kMostLive && live_in_all() < kMostLiveInAll) return true;
  enum class Turn { kFirst, kOnceSilent, kNever };
  const auto turn = [](const Live& live) {
    if (!live.receiver->ended()) return Turn::kOnceSilent;
    return live.receiver->durable() == live.receiver->received() ? Turn::kFirst : Turn::kNever;
  };
  const auto next = std::min_element(node.live.begin(), node.live.end(), [&](const Live& a, const Live& b) {
    return std::pair(turn(a), a.heard_at) < std::pair(turn(b), b.heard_at);
  });
  if (next == node.live.end() || turn(*next) == Turn::kNever) return false;
  if (turn(*next) == Turn::kOnceSilent) {
    if (now - next->heard_at < kEpochSilence) {
      ++rival_heartbeats_;
      return false;
    }
    next->receiver->crash(out);
  }
  retire(node, static_cast<std::size_t>(next - node.live.begin()));
  return true;
}

Receiver::Live& Receiver::open(Node& node, std::int32_t number, std::int64_t epoch,
                               const EpochPosition& start) {
  auto receiver = std::make_unique<EpochReceiver>(number, epoch, start, options_);
  receiver->set_credit_open(credit_open_);
  node.live.push_back(
      {.receiver = std::move(receiver), .acked_received = start.contiguous, .last_acks = kLastAcks});
  return node.live.back();
}

void Receiver::retire(Node& node, std::size_t which) {
  const EpochReceiver& receiver = *node.live[which].receiver;
  node.past.push_back({.epoch = receiver.epoch(), .position = receiver.position(), .superseded_at = {}});
  node.live.erase(node.live.begin() + static_cast<std::ptrdiff_t>(which));
  if (node.past.size() <= kMostPastEpochs) return;
  const auto over =
      std::find_if(node.past.begin(), node.past.end(), [](const Past& past) { return past.position.ended; });
  if (over != node.past.end()) node.past.erase(over);
}

// Two nodes with one number are received in turns; a node that was started again is not received before.
void Receiver::note_rivals(const Node& node, const Live& live) {
  if (live.heard_at == WallTime{}) return;
  const bool rival = std::any_of(node.live.begin(), node.live.end(), [&](const Live& other) {
    return &other != &live && !other.receiver->ended() && other.heard_at > live.heard_at;
  });
  if (rival) ++rival_heartbeats_;
}

void Receiver::close_past(Node& node, std::int32_t number, Past& past, std::vector<Delivery>& out) {
  Live& live = open(node, number, past.epoch, past.position);
  live.receiver->crash(out);
  // Behind all others: it is not the one that the node lives in.
  std::rotate(node.live.begin(), node.live.end() - 1, node.live.end());
}

// `epoch` has just been received.
void Receiver::close_silent(Node& node, std::int32_t number, std::int64_t epoch, WallTime now,
                            std::vector<Delivery>& out) {
  for (Live& live : node.live) {
    if (live.receiver->epoch() == epoch) break;  // those opened later stay
    if (now - live.heard_at >= kLongSilence) live.receiver->crash(out);
  }
  for (std::size_t k = 0; k < node.past.size();) {
    Past& past = node.past[k];
    if (!past.position.ended && !past.superseded_at) past.superseded_at = now;
    const bool silent = !past.position.ended && now - *past.superseded_at >= kLongSilence;
    if (silent && node.live.size() < kMostLive && live_in_all() < kMostLiveInAll) {
      close_past(node, number, past, out);
      node.past.erase(node.past.begin() + static_cast<std::ptrdiff_t>(k));
    } else {
      ++k;
    }
  }
}

void Receiver::give_up(std::int32_t node, std::int64_t epoch, std::vector<Delivery>& out) {
  const auto found = nodes_.find(node);
  if (found == nodes_.end()) return;
  if (Live* live = find_live(found->second, epoch)) return live->receiver->crash(out);
  Past* const past = find_past(found->second, epoch);
  if (!past || past->position.ended) return;
  close_past(found->second, node, *past, out);
  past->position.ended = past->position.crashed = true;
}

void Receiver::finish(WallTime now, bool leaves_open, std::vector<Delivery>& out) {
  for (auto& [number, node] : nodes_) {
    for (std::size_t k = 0; k < node.live.size(); ++k) {
      const bool superseded = k + 1 < node.live.size();
      if (!superseded && leaves_open) continue;
      if (now - node.live[k].heard_at >= (superseded ? kEpochSilence : kLongSilence))
        node.live[k].receiver->crash(out);
    }
    const bool long_silence = !leaves_open && began_at_ && now - *began_at_ >= kLongSilence;
    for (Past& past : node.past)
      if (!past.position.ended && (past.superseded_at || long_silence)) {
        close_past(node, number, past, out);
        past.position.ended = past.position.crashed = true;
      }
  }
}

void Receiver::was_held(std::chrono::nanoseconds duration) {
  if (began_at_) *began_at_ += duration;
  for (auto& [number, node] : nodes_) {
    for (Live& live : node.live)
      if (live.heard_at != WallTime{}) live.heard_at += duration;
    for (Past& past : node.past)
      if (past.superseded_at) *past.superseded_at += duration;
  }
}

void Receiver::durable(std::int32_t node, std::int64_t epoch, std::int64_t sequence) {
  const auto found = nodes_.find(node);
  if (found == nodes_.end()) return;
  if (Live* live = find_live(found->second, epoch)) live->receiver->durable(sequence);
}

void Receiver::set_credit_open(bool open) {
  credit_open_ = open;
  for (auto& [number, node] : nodes_)
    for (Live& live : node.live) live.receiver->set_credit_open(open);
}

bool Receiver::is_due(const Live& live, WallTime now) const {
  const EpochReceiver& epoch = *live.receiver;
  const bool much_credit_is_used = epoch.received() - live.acked_received >= options_.window / 4;
  // An ack that is lost must not cost the node a whole period: of memory it could free, or of credit it waits
  // for.
  const bool may_wait = live.next - 1 > epoch.received() && epoch.received() == live.acked_received;
  const bool not_heard = (live.base <= epoch.durable() || may_wait) && now - live.heard_at < kEpochSilence;
  return epoch.durable() > live.acked_durable || much_credit_is_used ||
         now - live.acked_at >= (not_heard ? kRepeatPeriod : kAckPeriod);
}

void Receiver::acknowledge(Node& node, Live& live, WallTime now, std::vector<Ack>& acks) const {
  const bool due = is_due(live, now);
  const bool asks = live.receiver->has_holes() && now - live.acked_at >= kAskPeriod;
  if (!due && !asks) return;
  Ack ack = live.receiver->acknowledge(now);
  if (!due && ack.missing.empty()) return;
  live.acked_at = now;
  live.acked_durable = live.receiver->durable();
  live.acked_received = live.receiver->received();
  ack.incarnation = incarnation_;
  ack.number = ++node.ack_number;
  acks.push_back(std::move(ack));
}

std::vector<Ack> Receiver::due(WallTime now) {
  std::vector<Ack> acks;
  for (auto& [number, node] : nodes_) {
    for (std::size_t k = 0; k < node.live.size();) {
      Live& live = node.live[k];
      const EpochReceiver& epoch = *live.receiver;
      const bool superseded = k + 1 < node.live.size();
      const bool over =
          epoch.ended() && epoch.durable() == epoch.received() && (superseded || epoch.given_up());
      const std::size_t before = acks.size();
      acknowledge(node, live, now, acks);
      if (over && acks.size() > before && --live.last_acks == 0)
        retire(node, k);
      else
        ++k;
    }
  }
  return acks;
}

}  // namespace roadbalance
