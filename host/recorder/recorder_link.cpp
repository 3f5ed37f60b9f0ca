#include "host/recorder/recorder_link.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
// At the end the last acks are repeated until each node has heard that all is durable, or is silent.
constexpr milliseconds kNodeSilence{12'000};
constexpr milliseconds kMostLastAcks{15'000};
constexpr milliseconds kEpochGone{1000};
// Some heartbeats of every node: before, nobody knows who is there to be waited for.
constexpr milliseconds kListening{1000};

}  // namespace

RecorderLink::RecorderLink(RecorderLinkOptions options, std::int64_t incarnation,
                           const RecordState& recovered)
    : options_(std::move(options)),
      receiver_(incarnation),
      control_(incarnation, options_.start, options_.seed, !options_.scope.only.empty()),
      tally_(recovered) {
  for (const auto& [key, epoch] : recovered.epoch) receiver_.recover(key.first, key.second, epoch.position);
}

// Nobody was heard while we were held, also of those whose datagrams wait behind the one that comes first.
void RecorderLink::count_silence_to(WallTime now) {
  constexpr std::chrono::seconds kHeld{1};
  if (called_at_ && now - *called_at_ > kHeld) {
    receiver_.was_held(now - *called_at_);
    for (auto& [key, heard] : heard_) heard.at += now - *called_at_;
  }
  called_at_ = now;
}

void RecorderLink::take(std::string_view channel, std::span<const std::uint8_t> bytes, WallTime now) {
  count_silence_to(now);
  if (channel.starts_with(kBlockChannels)) return on_block(bytes, now);
  if (channel.starts_with("RB_HEARTBEAT_")) return on_heartbeat(bytes, now);
  if (channel.starts_with("RB_REPLY_")) return on_reply(bytes);
}

void RecorderLink::on_heartbeat(std::span<const std::uint8_t> bytes, WallTime now) {
  const auto heartbeat = decode_heartbeat(bytes);
  if (!heartbeat) {
    ++refused_;
    return;
  }
  set_apart(*heartbeat);
  if (!is_ours({heartbeat->node, heartbeat->epoch})) return;
  control_.take(*heartbeat);
  // What obeys another recorder is in that one's record; here it would be a fragment with gaps that are none.
  const bool ours = receiver_.find(heartbeat->node, heartbeat->epoch) ||
                    control_.has_obeyed(heartbeat->node, heartbeat->epoch);
  foreign_.take(*heartbeat, incarnation(), now);
  if (!ours) return;
  receiver_.take(*heartbeat, now, delivered_);
  if (!receiver_.find(heartbeat->node, heartbeat->epoch)) return;
  hear(*heartbeat, now);
  tally_.take(*heartbeat);
}

void RecorderLink::on_block(std::span<const std::uint8_t> bytes, WallTime now) {
  if (accept(bytes, block_) != Refusal::kNone) {
    ++refused_;
    return;
  }
  if (!is_ours({block_.header.node, block_.header.epoch})) return;  // another recorder's, or recording's
  const std::size_t before = delivered_.size();
  receiver_.take(block_, now, delivered_);
  if (delivered_.size() > before && control_.is_owned(block_.header.node, block_.header.epoch))
    last_news_ = now;
}

void RecorderLink::on_reply(std::span<const std::uint8_t> bytes) {
  const auto reply = decode_reply(bytes);
  if (reply)
    control_.take(*reply);
  else
    ++refused_;
}

void RecorderLink::durable(const DurableMark& mark, WallTime now) {
  if (control_.is_owned(mark.node, mark.epoch)) last_news_ = now;
  receiver_.durable(mark.node, mark.epoch, mark.sequence);
}

void RecorderLink::set_credit_open(bool open) {
  credit_open_ = open;
  receiver_.set_credit_open(open);
}

void RecorderLink::turn(WallTime now, const Publish& publish) {
  count_silence_to(now);
  for (; tallied_ < delivered_.size(); ++tallied_) tally_.take(delivered_[tallied_]);
  for (const Ack& ack : receiver_.due(now))
    if (!publish(ack_channel(ack.node), encode(ack))) ++unsent_;
  for (const auto& command : control_.due(now)) send(command, publish);
}

std::vector<Delivery> RecorderLink::deliveries() {
  for (; tallied_ < delivered_.size(); ++tallied_) tally_.take(delivered_[tallied_]);
  tallied_ = 0;
  if (delivered_.empty()) return {};
  // What comes next is about as much; a vector that grows moves all of its blocks.
  std::vector<Delivery> next;
  next.reserve(2 * delivered_.size());
  return std::exchange(delivered_, std::move(next));
}

void RecorderLink::stop(WallTime now) {
  if (stopping_) return;
  stopping_ = true;
  stopped_at_ = now;
  control_.stop();
}

bool RecorderLink::over(WallTime now) {
  if (!listening_since_) listening_since_ = now;
  const bool has_listened = now - *listening_since_ >= kListening;
  const bool silent = now - std::max(last_news_, stopped_at_) >= options_.patience;
  const bool done = (stopping_ && ((has_listened && all_ended(now) && !control_.is_asking(now)) || silent)) ||
                    (options_.end_with_nodes && expected_have_ended(now));
  if (!done) working_at_ = now;
  return done && (nodes_have_let_go(now) || now - working_at_ >= kMostLastAcks);
}

void RecorderLink::finish(WallTime now) {
  const EpochScope& scope = options_.scope;
  for (const auto& [node, epoch] : scope.given_up) receiver_.give_up(node, epoch, delivered_);
  receiver_.finish(now, scope.leaves_open, delivered_);
  for (auto& [key, heard] : heard_) heard.devices.finish(key.first, device_notes_);
}

void RecorderLink::farewell(const Publish& publish) {
  // A node that is released says no more whose samples it holds, and nobody would fetch them: one with
  // something that is not on the disk, or of which only answers have come, keeps its owner's number, and is
  // free for the next one when the lease is over.
  for (const auto& command : control_.farewell()) {
    const NodeEpoch key{command.node, command.epoch};
    if (!control_.was_started(key.first, key.second) ||
        (heard_.contains(key) && has_ended(key) && !holds_blocks(key)))
      send(command, publish);
  }
}

void RecorderLink::set_incarnation(std::int64_t incarnation) {
  receiver_.set_incarnation(incarnation);
  control_.set_incarnation(incarnation);
}

RecorderReport RecorderLink::report() const {
  RecorderReport report = tally_.report();
  for (NodeReport& node : report.node) {
    node.started = control_.was_started(node.node, node.epoch);
    if (const auto* epoch = receiver_.find(node.node, node.epoch); epoch && node.first_scan_block > 0)
      node.has_durable_samples = node.has_durable_samples || epoch->durable() >= node.first_scan_block;
    node.holds_blocks = holds_blocks({node.node, node.epoch});
  }
  report.blocks_refused = refused_;
  for (const std::int64_t count : receiver_.refused()) report.blocks_refused += count;
  report.rival_heartbeats = receiver_.rival_heartbeats();
  report.foreign = foreign_.nodes();
  report.unsent = unsent_;
  report.incarnation = incarnation();
  return report;
}

LinkCounters RecorderLink::counters() const {
  const RecorderReport counted = report();
  return {.refused = counted.blocks_refused,
          .rivals = counted.rival_heartbeats,
          .unsent = unsent_,
          .node = tally_.losses()};
}

void RecorderLink::fill(RecorderStatus& status) const {
  if (stopping_) status.state = RecorderState::kStopping;
  status.incarnation = incarnation();
  status.refused_datagrams = refused_;
  static_assert(std::tuple_size_v<Receiver::RefusedCounts> ==
                std::tuple_size_v<decltype(status.refused_blocks)>);
  status.refused_blocks = receiver_.refused();
  status.rivals = receiver_.rival_heartbeats();
  status.unsent = unsent_;
}

bool RecorderLink::is_ours(const NodeEpoch& key) const {
  const auto& nodes = options_.nodes;
  return (nodes.empty() || std::find(nodes.begin(), nodes.end(), key.first) != nodes.end()) &&
         options_.scope.has(key) && !former_.contains(key);
}

// It stays so when its rest is fetched beside this recording, by an incarnation that is nobody's of before.
void RecorderLink::set_apart(const Heartbeat& heartbeat) {
  const NodeEpoch key{heartbeat.node, heartbeat.epoch};
  if (!holds_samples(heartbeat) || !options_.scope.is_former(heartbeat.owner)) return;
  if (receiver_.find(key.first, key.second) || former_.contains(key)) return;
  if (former_.size() >= NodeControl::kMostEpochs) former_.erase(former_.begin());
  former_.insert(key);
}

// No more are kept than the receiver has epochs.
void RecorderLink::hear(const Heartbeat& heartbeat, WallTime now) {
  const NodeEpoch key{heartbeat.node, heartbeat.epoch};
  if (!heard_.contains(key))
    std::erase_if(heard_,
                  [this](const auto& old) { return !receiver_.find(old.first.first, old.first.second); });
  Heard& heard = heard_[key];
  heard.at = now;
  heard.base = heartbeat.base;
  heard.next = heartbeat.next;
  heard.devices.take(heartbeat.device_counts);
  // A disk that fails takes no notes either; they would only fill the memory.
  if (credit_open_) heard.devices.due(heartbeat.node, now, device_notes_);
}

// Its last heartbeat may be from before its last blocks: a node that has sent these and was held since keeps
// them until it hears that they are durable, and the next recording would take them for its own.
bool RecorderLink::holds_blocks(NodeEpoch key) const {
  const auto heard = heard_.find(key);
  if (heard == heard_.end()) return false;
  const auto* epoch = receiver_.find(key.first, key.second);
  const bool is_its_own = epoch && !epoch->given_up();  // and not a crash that was declared for it
  const std::int64_t next = std::max(heard->second.next, is_its_own ? epoch->received() + 1 : 0);
  return heard->second.base < next;
}

bool RecorderLink::has_ended(NodeEpoch key) const {
  const auto* epoch = receiver_.find(key.first, key.second);
  return !epoch || (epoch->ended() && epoch->durable() == epoch->received());
}

// It is silent, and a later epoch of the node was heard: nothing of it is waited for.
bool RecorderLink::is_superseded(NodeEpoch key, WallTime now) const {
  const WallTime at = heard_.at(key).at;
  return now - at >= kEpochGone && std::any_of(heard_.begin(), heard_.end(), [&](const auto& other) {
           return other.first.first == key.first && other.second.at > at;
         });
}

// Every epoch that was started has its end on the disk.
bool RecorderLink::all_ended(WallTime now) const {
  return std::all_of(heard_.begin(), heard_.end(), [&](const auto& heard) {
    const auto& [node, epoch] = heard.first;
    return is_superseded(heard.first, now) || !control_.was_started(node, epoch) || has_ended(heard.first);
  });
}

// Every node of options.nodes was heard and has its end on the disk.
bool RecorderLink::expected_have_ended(WallTime now) const {
  return std::all_of(options_.nodes.begin(), options_.nodes.end(), [&](std::int32_t node) {
    bool was_heard = false;
    for (const auto& [key, heard] : heard_) {
      if (key.first != node || is_superseded(key, now)) continue;
      if (!has_ended(key)) return false;
      was_heard = true;
    }
    return was_heard;
  });
}

// Every epoch whose end is on the disk says that it has nothing to keep any more, or says nothing.
bool RecorderLink::nodes_have_let_go(WallTime now) const {
  return std::all_of(heard_.begin(), heard_.end(), [&](const auto& heard) {
    const auto& [key, last] = heard;
    return !has_ended(key) || !holds_blocks(key) || now - last.at >= kNodeSilence;
  });
}

void RecorderLink::send(const Command& command, const Publish& publish) {
  if (!publish(command_channel(command.node), encode(command))) ++unsent_;
}

}  // namespace roadbalance
