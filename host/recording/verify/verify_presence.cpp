#include "host/recording/verify/verify_presence.hpp"

#include <algorithm>

namespace roadbalance {

void PresenceCheck::take_time(std::int64_t utc_us) {
  const Stamp stamp = clocks_.stamp(utc_us);
  if (utc_us != 0 && clocks_.utc_us(stamp) > clocks_.utc_us(last_)) last_ = stamp;
}

void PresenceCheck::take(const Note& note) {
  clocks_.take(note);
  take_time(note.time_us);
  const Stamp stamp = clocks_.stamp(note.time_us);
  if (note.kind == NoteKind::kStarted) stopped_ = {};  // it goes on
  if (note.kind == NoteKind::kStopping) stopped_ = stamp;
  if (note.kind != NoteKind::kNodeMissing && note.kind != NoteKind::kNodeThere) return;
  const auto number = static_cast<std::int32_t>(note.a);
  Node& node = node_[number];
  if (!note.text.empty()) node.name = note.text;
  if (note.kind == NoteKind::kNodeMissing) {
    const auto cause = static_cast<AbsenceCause>(note.b);
    // A recorder that is started again misses it again; and what happened replaces that it is not heard.
    const bool is_news = !node.is_missing || node.now.absence.cause == AbsenceCause::kSilent;
    if (is_news) node.now.absence.cause = cause;
    if (!node.is_missing)
      node.now = {
          .absence = {.node = number, .cause = cause, .from_begin = cause == AbsenceCause::kNeverCame},
          .since = stamp};
    node.is_missing = true;
  } else if (node.is_missing) {
    node.is_missing = false;
    if (note.b == 0) return;
    node.now.until = stamp;
    node.past.push_back(node.now);
  }
}

Absence PresenceCheck::absence_of(const Stretch& stretch, const Stamp& until) const {
  Absence absence = stretch.absence;
  absence.since_us = clocks_.utc_us(stretch.since);
  absence.seconds =
      1e-6 * static_cast<double>(std::max<std::int64_t>(0, clocks_.utc_us(until) - absence.since_us));
  return absence;
}

std::vector<Absence> PresenceCheck::absences(const std::set<std::int32_t>& ended) const {
  std::vector<Absence> all;
  for (const auto& [number, node] : node_) {
    for (const Stretch& past : node.past) all.push_back(absence_of(past, past.until));
    if (!node.is_missing || (node.now.absence.cause == AbsenceCause::kSilent && ended.contains(number)))
      continue;
    all.push_back(absence_of(node.now, stopped_.utc_us != 0 ? stopped_ : last_));
    all.back().to_end = true;
  }
  return all;
}

std::string PresenceCheck::sentence(const Absence& absence) const {
  return node_words(absence.node, name_of(absence.node)) + " " + words(absence);
}

std::string PresenceCheck::name_of(std::int32_t node) const {
  const auto known = node_.find(node);
  return known == node_.end() ? "" : known->second.name;
}

}  // namespace roadbalance
