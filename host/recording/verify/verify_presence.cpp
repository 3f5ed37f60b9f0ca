#include "host/recording/verify/verify_presence.hpp"

#include <algorithm>

namespace roadbalance {
namespace {

double seconds(std::int64_t from_us, std::int64_t to_us) {
  return 1e-6 * static_cast<double>(std::max<std::int64_t>(0, to_us - from_us));
}

}  // namespace

void PresenceCheck::take_time(std::int64_t utc_us) {
  last_us_ = std::max(last_us_, utc_us);
}

void PresenceCheck::take(const Note& note) {
  take_time(note.time_us);
  if (note.kind == NoteKind::kStarted) stopped_us_ = 0;  // it goes on
  if (note.kind == NoteKind::kStopping) stopped_us_ = note.time_us;
  if (note.kind != NoteKind::kNodeMissing && note.kind != NoteKind::kNodeThere) return;
  const auto number = static_cast<std::int32_t>(note.a);
  Node& node = node_[number];
  if (!note.text.empty()) node.name = note.text;
  if (note.kind == NoteKind::kNodeMissing) {
    const auto cause = static_cast<AbsenceCause>(note.b);
    // A recorder that is started again misses it again; and what happened replaces that it is not heard.
    const bool is_news = !node.is_missing || node.now.cause == AbsenceCause::kSilent;
    if (is_news) node.now.cause = cause;
    if (!node.is_missing)
      node.now = {.node = number,
                  .cause = cause,
                  .since_us = note.time_us,
                  .from_begin = cause == AbsenceCause::kNeverCame};
    node.is_missing = true;
  } else if (node.is_missing) {
    node.is_missing = false;
    if (note.b == 0) return;
    node.now.seconds = seconds(node.now.since_us, note.time_us);
    node.past.push_back(node.now);
  }
}

std::vector<Absence> PresenceCheck::absences(const std::set<std::int32_t>& ended) const {
  std::vector<Absence> all;
  for (const auto& [number, node] : node_) {
    all.insert(all.end(), node.past.begin(), node.past.end());
    if (!node.is_missing || (node.now.cause == AbsenceCause::kSilent && ended.contains(number))) continue;
    Absence now = node.now;
    now.to_end = true;
    now.seconds = seconds(now.since_us, stopped_us_ != 0 ? stopped_us_ : last_us_);
    all.push_back(now);
  }
  return all;
}

std::string PresenceCheck::name_of(std::int32_t node) const {
  const auto known = node_.find(node);
  return known == node_.end() ? "" : known->second.name;
}

}  // namespace roadbalance
