#include "host/recorder/node_presence.hpp"

#include <algorithm>
#include <utility>

namespace roadbalance {
namespace {

constexpr std::size_t kMostPast = 256;  // a node that flaps for days
constexpr std::size_t kMostFormer = 8;
// Ten heartbeats: who is not heard for so long has perhaps not heard either.
constexpr std::chrono::seconds kMoment{1};

double length_s(WallTime::duration time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

NodePresence::NodePresence(Options options, const RecordState& recovered) : options_(std::move(options)) {
  if (!options_.misses) return;
  for (const ExpectedNode& node : options_.expected) nodes_[node.number];
  for (const auto& [key, epoch] : recovered.epoch) {
    Node& node = nodes_[key.first];
    const bool is_first = !std::exchange(node.came, true);
    node.is_over = (is_first || node.is_over) && epoch.position.ended;
    node.was_over_before = node.is_over;
    if (!epoch.position.ended) remember(node, key.second);
  }
}

// Why an epoch ended in an earlier run that run has noted.
void NodePresence::begin(WallTime now) {
  began_ = now;
  for (auto& [number, node] : nodes_) {
    node.heard = std::max(node.heard, now);
    if (node.is_over && node.cause == AbsenceCause::kNone) node.cause = AbsenceCause::kSourceOver;
  }
  for (const ExpectedNode& expected : options_.expected)
    if (Node& node = nodes_[expected.number]; expected.is_missing && !node.came)
      lose(node, AbsenceCause::kNeverCame, now, now);
  for (const Absence& before : options_.before) {
    const WallTime since =
        now - std::chrono::microseconds(std::max<std::int64_t>(0, options_.utc_us - before.since_us));
    if (!before.to_end) {
      past_.push_back({.absence = before, .since = since});
      continue;
    }
    Node& node = nodes_[before.node];
    lose(node, before.cause, since, now);
    node.is_noted = true;
  }
}

void NodePresence::take_foreign(std::int32_t number, WallTime now) {
  const auto node = nodes_.find(number);
  if (node == nodes_.end() || node->second.came) return;
  node->second.heard = now;
  node->second.is_foreign = true;
}

void NodePresence::take(const Heartbeat& beat, WallTime now) {
  if (!options_.misses || !began_ || (nodes_.size() >= kMostNodes && !nodes_.contains(beat.node))) return;
  const bool measures = beat.state == NodeState::kStarted;
  if (!measures && !beat.is_over()) return;
  Node& node = nodes_[beat.node];
  const bool is_former = std::ranges::find(node.former, beat.epoch) != node.former.end();
  if (is_former && node.epoch != 0) {
    if (measures) node.heard = now;  // another node has its number
    return;
  }
  const bool other_epoch = node.came && node.epoch != beat.epoch && !is_former;
  if (node.is_over && !other_epoch) return;
  if (beat.is_over()) {
    if (other_epoch) return;
    const bool was_cut_off = node.cause == AbsenceCause::kSilent;
    if (stopped_ && !was_cut_off && !has_ended_early(node, beat, now)) {
      node.came = node.came || beat.end_cause == AbsenceCause::kStopped;
      return;
    }
    node.came = node.is_over = true;
    node.epoch = beat.epoch;
    node.heard = now;
    if (stopped_ && beat.end_cause == AbsenceCause::kStopped) return find(beat.node, node, false, now);
    if (node.cause == AbsenceCause::kNone || was_cut_off)
      lose(node, beat.end_cause, was_cut_off ? node.since : std::min(now, stopped_.value_or(now)), now);
    if (stopped_ && is_missed(node)) note_missing(beat.node, node, node.cause);
    return;
  }
  WallTime there = now;
  if (!other_epoch && node.next_epoch != 0) {
    // It goes on: the other epoch is of another node with its number.
    remember(node, std::exchange(node.next_epoch, 0));
  } else if (other_epoch && node.cause == AbsenceCause::kNone) {
    // It was started again before it was missed, unless it is heard again.
    if (std::exchange(node.next_epoch, beat.epoch) != beat.epoch) node.next_at = now;
    if (now - node.heard < kMoment) return;
    there = node.next_at;
    lose(node, AbsenceCause::kSilent, node.heard, now);
  }
  node.next_epoch = 0;
  if (node.cause != AbsenceCause::kNone) find(beat.node, node, other_epoch, there);
  if (other_epoch && node.epoch != 0) remember(node, node.epoch);
  std::erase(node.former, beat.epoch);
  node.came = true;
  node.is_over = false;
  node.epoch = beat.epoch;
  node.heard = now;
}

void NodePresence::remember(Node& node, std::int64_t epoch) {
  if (node.former.size() >= kMostFormer) node.former.erase(node.former.begin());
  node.former.push_back(epoch);
}

void NodePresence::lose(Node& node, AbsenceCause cause, WallTime since, WallTime now) {
  node.cause = cause;
  node.since = since;
  node.seen = now;
  node.is_noted = false;
}

bool NodePresence::is_missed(const Node& node) const {
  switch (node.cause) {
    case AbsenceCause::kNone:
    case AbsenceCause::kSourceOver:
      return false;
    case AbsenceCause::kStopped:
    case AbsenceCause::kProgramEnded:
      return !options_.nodes_end_it;
    case AbsenceCause::kDeviceFailed:
    case AbsenceCause::kSilent:
    case AbsenceCause::kNeverCame:
      break;
  }
  return true;
}

// Behind the stop each node ends as commanded, and one that was cut off has measured till then.  But a node
// that can hear the command and ends otherwise did so before the instant that it names.
bool NodePresence::has_ended_early(const Node& node, const Heartbeat& last, WallTime now) const {
  return stop_ == Stop::kAsked && last.end_cause != AbsenceCause::kStopped && node.came &&
         now - node.heard < kMoment;
}

void NodePresence::note_missing(std::int32_t number, Node& node, AbsenceCause cause) {
  node.is_noted = true;
  notes_.push_back({.kind = NoteKind::kNodeMissing,
                    .a = number,
                    .b = static_cast<std::int64_t>(cause),
                    .text = name_of(number),
                    .at = node.since});
}

void NodePresence::note_there(std::int32_t number, bool lacks, WallTime now) {
  notes_.push_back(
      {.kind = NoteKind::kNodeThere, .a = number, .b = lacks ? 1 : 0, .text = name_of(number), .at = now});
}

// A node that was only not heard sends now what it measured meanwhile.
void NodePresence::find(std::int32_t number, Node& node, bool other_epoch, WallTime now) {
  const bool lacks = other_epoch || node.cause != AbsenceCause::kSilent;
  const bool was_missed = is_missed(node);
  const AbsenceCause cause = std::exchange(node.cause, AbsenceCause::kNone);
  // An earlier run may have noted that it is missing.
  if (std::exchange(node.was_over_before, false) && !was_missed) return note_there(number, true, now);
  if (!was_missed || (!node.is_noted && !lacks)) return;
  if (!node.is_noted) note_missing(number, node, cause);
  note_there(number, lacks, now);
  if (!lacks || past_.size() >= kMostPast) return;
  past_.push_back({.absence = {.node = number,
                               .cause = cause,
                               .seconds = length_s(now - node.since),
                               .from_begin = cause == AbsenceCause::kNeverCame},
                   .since = node.since});
}

void NodePresence::was_held(WallTime::duration held) {
  if (began_) *began_ += held;
  for (auto& [number, node] : nodes_) node.heard += held;
}

void NodePresence::turn(WallTime now, std::vector<NoteToRecord>& notes) {
  if (!options_.misses) return;
  if (!began_) begin(now);
  for (auto& [number, node] : nodes_) {
    if (stopped_) break;
    if (node.cause == AbsenceCause::kNone && now - node.heard >= kSilence)
      lose(node, node.came ? AbsenceCause::kSilent : AbsenceCause::kNeverCame,
           node.came ? node.heard : *began_, now);
    const bool waits = node.cause < AbsenceCause::kSilent && now - node.seen < kEndsTogether;
    if (is_missed(node) && !node.is_noted && !waits) note_missing(number, node, node.cause);
  }
  notes.insert(notes.end(), notes_.begin(), notes_.end());
  notes_.clear();
}

void NodePresence::stop(WallTime now, Stop how) {
  if (stopped_ || !options_.misses) return;
  if (!began_) begin(now);
  stopped_ = now;
  stop_ = how;
  for (auto& [number, node] : nodes_) {
    const bool ends_together = how == Stop::kBySignal && node.cause == AbsenceCause::kProgramEnded;
    // A recorder that was killed in a stop and is started again goes on with it, and first hears of those
    // that were stopped by itself before.
    const bool is_from_before = node.cause == AbsenceCause::kStopped && node.seen - *began_ < kMoment;
    if (is_missed(node) && !node.is_noted && !ends_together && !is_from_before)
      note_missing(number, node, node.cause);
  }
}

void NodePresence::finish(WallTime now) {
  if (!options_.misses) return;
  if (!began_) begin(now);
  for (const ExpectedNode& expected : options_.expected) {
    Node& node = nodes_[expected.number];
    if (node.came || node.is_foreign || node.is_noted) continue;
    if (node.cause == AbsenceCause::kNone) lose(node, AbsenceCause::kNeverCame, *began_, now);
    note_missing(expected.number, node, node.cause);
  }
}

std::vector<AbsentNode> NodePresence::absent() const {
  std::vector<AbsentNode> absent;
  for (const auto& [number, node] : nodes_)
    if (node.is_noted && is_missed(node)) absent.push_back({number, node.cause});
  return absent;
}

std::vector<Absence> NodePresence::absences(WallTime now, std::int64_t utc_us) const {
  const auto utc_of = [&](WallTime at) {
    return utc_us - std::chrono::duration_cast<std::chrono::microseconds>(now - at).count();
  };
  std::vector<Absence> all;
  for (const Past& past : past_) {
    all.push_back(past.absence);
    all.back().since_us = utc_of(past.since);
  }
  for (const auto& [number, node] : nodes_)
    if (node.is_noted && is_missed(node))
      all.push_back({.node = number,
                     .cause = node.cause,
                     .since_us = utc_of(node.since),
                     .seconds = length_s(stopped_.value_or(now) - node.since),
                     .from_begin = node.cause == AbsenceCause::kNeverCame,
                     .to_end = true});
  std::ranges::stable_sort(all, {}, &Absence::node);
  return all;
}

std::string NodePresence::name_of(std::int32_t number) const {
  const auto node = std::ranges::find(options_.expected, number, &ExpectedNode::number);
  return node == options_.expected.end() ? "" : node->name;
}

}  // namespace roadbalance
