#include "host/recorder/recorder_link.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kMostLastAcks{15'000};  // at the end, until each node has heard that all is durable
// Some heartbeats of every node: before, the nodes to be waited for are not known.
constexpr milliseconds kListening{1000};

// Nobody waits for the answer of a recorder that is begun before its nodes: they have time to be heard.
milliseconds notice_of(const RecorderLinkOptions& options) {
  constexpr milliseconds kUnheard{600};
  return options.heard.empty() ? kUnheard : NodeControl::notice_for(options.heard.size());
}

// Who leaves the start of nodes to others leaves their stop to them, too; a rest that is fetched has ended.
NodePresence::Options presence_of(const RecorderLinkOptions& options) {
  return {.misses = options.start && options.scope.only.empty(),
          .nodes_end_it = options.end_with_nodes,
          .expected = options.expected,
          .before = options.absent_before,
          .utc_us = options.utc_us};
}

}  // namespace

RecorderLink::RecorderLink(RecorderLinkOptions options, std::int64_t incarnation,
                           const RecordState& recovered)
    : options_(std::move(options)),
      heard_before_(options_.heard),
      receiver_(incarnation),
      control_(incarnation, options_.start, options_.seed, !options_.scope.only.empty(), notice_of(options_)),
      counters_(recovered),
      heard_(receiver_, control_),
      presence_(presence_of(options_), recovered) {
  for (const ExpectedNode& node : options_.expected) nodes_led_.insert(node.number);
  for (const auto& [key, epoch] : recovered.epoch) receiver_.recover(key.first, key.second, epoch.position);
}

// No node was heard while we were held, also those whose datagrams wait behind the one that comes first.
void RecorderLink::count_silence_to(WallTime now) {
  constexpr std::chrono::seconds kHeld{1};
  if (called_at_ && now - *called_at_ > kHeld) {
    receiver_.was_held(now - *called_at_);
    heard_.was_held(now - *called_at_);
    presence_.was_held(now - *called_at_);
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
  hear(*heartbeat, now);
}

void RecorderLink::hear(const Heartbeat& heartbeat, WallTime now) {
  set_apart(heartbeat);
  if (!is_ours({heartbeat.node, heartbeat.epoch}) || !has_room_for(heartbeat.node, now)) return;
  control_.take(heartbeat);
  // An epoch that obeys another recorder is in that one's record; here it would be a fragment with gaps that
  // are none.
  const bool ours =
      receiver_.find(heartbeat.node, heartbeat.epoch) || control_.has_obeyed(heartbeat.node, heartbeat.epoch);
  foreign_.take(heartbeat, incarnation(), now);
  if (!ours && heartbeat.owner != 0) presence_.take_foreign(heartbeat.node, now);
  if (!ours) return;
  receiver_.take(heartbeat, now, delivered_);
  if (!receiver_.find(heartbeat.node, heartbeat.epoch)) return;
  // A disk that fails takes no notes either; they would only fill the memory.
  heard_.take(heartbeat, now, credit_open_, device_notes_);
  counters_.take(heartbeat);
  presence_.take(heartbeat, now);
  note_early_end(heartbeat, now);
}

// The rest of a recording that is over: a node that was cut off measured to its stop, unless it ended before.
void RecorderLink::note_early_end(const Heartbeat& heartbeat, WallTime now) {
  const bool ended_early = heartbeat.is_over() && heartbeat.end_cause != AbsenceCause::kStopped &&
                           heartbeat.end_cause != AbsenceCause::kSourceOver;
  if (options_.scope.only.empty() || !ended_early) return;
  if (!ended_early_.insert({heartbeat.node, heartbeat.epoch}).second) return;
  notes_.push_back({.kind = NoteKind::kNodeMissing,
                    .a = heartbeat.node,
                    .b = static_cast<std::int64_t>(heartbeat.end_cause),
                    .at = now});
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
  for (const Heartbeat& heartbeat : std::exchange(heard_before_, {})) hear(heartbeat, now);
  for (; counted_ < delivered_.size(); ++counted_) counters_.take(delivered_[counted_]);
  for (const Ack& ack : receiver_.due(now))
    if (!publish(ack_channel(ack.node), encode(ack))) ++unsent_;
  for (const auto& command : control_.due(now)) send(command, publish);
  presence_.turn(now, notes_);
}

std::vector<Delivery> RecorderLink::deliveries() {
  for (; counted_ < delivered_.size(); ++counted_) counters_.take(delivered_[counted_]);
  counted_ = 0;
  if (delivered_.empty()) return {};
  // The next ones are about as many; a vector that grows moves all of its blocks.
  std::vector<Delivery> next;
  next.reserve(2 * delivered_.size());
  return std::exchange(delivered_, std::move(next));
}

void RecorderLink::stop(WallTime now, const std::string& by) {
  if (stopping_) return;
  stopping_ = true;
  stopped_at_ = now;
  presence_.stop(now, by == kStoppedBySignal ? NodePresence::Stop::kBySignal : NodePresence::Stop::kAsked);
  presence_.turn(now, notes_);  // what is missed by now is noted before the stop
  if (options_.scope.only.empty()) notes_.push_back({.kind = NoteKind::kStopping, .text = by, .at = now});
  control_.stop();
}

bool RecorderLink::over(WallTime now) {
  if (!listening_since_) listening_since_ = now;
  const bool has_listened = now - *listening_since_ >= kListening;
  const bool silent = now - std::max(last_news_, stopped_at_) >= options_.patience;
  const bool done =
      (stopping_ && ((has_listened && heard_.all_ended(now) && !control_.is_asking(now)) || silent)) ||
      (options_.end_with_nodes && heard_.have_ended(options_.nodes, now));
  if (!done) working_at_ = now;
  return done && (heard_.all_have_let_go(now) || now - working_at_ >= kMostLastAcks);
}

void RecorderLink::finish(WallTime now) {
  const EpochScope& scope = options_.scope;
  for (const auto& [node, epoch] : scope.given_up) receiver_.give_up(node, epoch, delivered_);
  receiver_.finish(now, scope.leaves_open, delivered_);
  heard_.finish(device_notes_);
  presence_.finish(now);
  presence_.turn(now, notes_);
}

void RecorderLink::farewell(const Publish& publish) {
  // A node that is released does not report any more whose samples it holds, and they would not be fetched:
  // one with something that is not on the disk, or of which only answers have come, keeps its owner's number,
  // and is free for the next one when the lease is over.
  for (const auto& command : control_.farewell()) {
    const NodeEpoch key{command.node, command.epoch};
    if (!control_.was_started(key.first, key.second) || heard_.has_let_go(key)) send(command, publish);
  }
}

void RecorderLink::set_incarnation(std::int64_t incarnation) {
  receiver_.set_incarnation(incarnation);
  control_.set_incarnation(incarnation);
}

RecorderReport RecorderLink::report() const {
  RecorderReport report = counters_.report();
  for (NodeReport& node : report.node) {
    node.started = control_.was_started(node.node, node.epoch);
    if (const auto* epoch = receiver_.find(node.node, node.epoch); epoch && node.first_scan_block > 0)
      node.has_durable_samples = node.has_durable_samples || epoch->durable() >= node.first_scan_block;
    node.holds_blocks = heard_.holds_blocks({node.node, node.epoch});
    node.ended_early = ended_early_.contains({node.node, node.epoch});
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
          .node = counters_.losses()};
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
  status.absent = presence_.absent();
  const bool is_heard = called_at_ && *called_at_ - left_out_at_ < NodePresence::kSilence;
  status.left_out = is_heard ? left_out_ : 0;
}

bool RecorderLink::is_ours(const NodeEpoch& key) const {
  const auto& nodes = options_.nodes;
  return (nodes.empty() || std::find(nodes.begin(), nodes.end(), key.first) != nodes.end()) &&
         options_.scope.has(key) && !former_.contains(key);
}

// The table of nodes is bounded: numbers from the bus can be anything.
bool RecorderLink::has_room_for(std::int32_t node, WallTime now) {
  if (nodes_led_.contains(node)) return true;
  if (nodes_led_.size() < kMostNodes) return nodes_led_.insert(node).second;
  left_out_ = node;
  left_out_at_ = now;
  return false;
}

// It stays apart when its rest is fetched beside this recording, by an incarnation that no recording before
// had.
void RecorderLink::set_apart(const Heartbeat& heartbeat) {
  const NodeEpoch key{heartbeat.node, heartbeat.epoch};
  if (!holds_samples(heartbeat) || !options_.scope.is_former(heartbeat.owner)) return;
  if (receiver_.find(key.first, key.second) || former_.contains(key)) return;
  if (former_.size() >= NodeControl::kMostEpochs) former_.erase(former_.begin());
  former_.insert(key);
}

void RecorderLink::send(const Command& command, const Publish& publish) {
  if (!publish(command_channel(command.node), encode(command))) ++unsent_;
}

void RecorderLink::ForeignNodes::take(const Heartbeat& heartbeat, std::int64_t our_incarnation,
                                      WallTime now) {
  const std::string name = "node " + std::to_string(heartbeat.node);
  const auto known = nodes_.find(heartbeat.node);
  if (heartbeat.owner == 0 || heartbeat.owner == our_incarnation) {
    if (known == nodes_.end()) return;
    if (known->second.is_reported && heartbeat.owner != 0)
      sentences_.push_back(name + " obeys this recorder now");
    nodes_.erase(known);
    return;
  }
  if (known == nodes_.end()) {
    if (nodes_.size() < kMostNodes) nodes_[heartbeat.node] = {.since = now, .heard = now};
    return;
  }
  Node& node = known->second;
  if (now - std::exchange(node.heard, now) >= kPatience) node.since = now;  // it may have been free meanwhile
  if (node.is_reported || now - node.since < kPatience) return;
  node.is_reported = true;
  sentences_.push_back(name + " obeys another recorder (incarnation " + std::to_string(heartbeat.owner) +
                       "): only observed here until that one is silent or lets it go");
}

std::vector<std::int32_t> RecorderLink::ForeignNodes::nodes() const {
  std::vector<std::int32_t> numbers;
  for (const auto& [number, node] : nodes_)
    if (node.is_reported) numbers.push_back(number);
  return numbers;
}

}  // namespace roadbalance
