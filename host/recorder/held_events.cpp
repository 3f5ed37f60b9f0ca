#include "host/recorder/held_events.hpp"

#include <algorithm>
#include <array>
#include <cassert>

#include "common/bus/bus.hpp"

namespace roadbalance {
namespace {

// While the disk fails the nodes' blocks stay bounded by credit; other events have no such bound.
constexpr std::size_t kMostHeldForEvents = std::size_t{16} << 20;

// Neither that a recorder runs, for one that is started again and again would begin as many segments, nor
// that segments are to be deleted: these stay until it is noted.
bool is_news(NoteKind kind) {
  return kind != NoteKind::kStarted && kind != NoteKind::kTailCut && kind != NoteKind::kSegmentDeleted;
}

}  // namespace

void HeldEvents::await(const SealedBlock& block, WallTime now) {
  const BlockHeader& header = block.header;
  if (pending_.empty()) oldest_ = now;
  pending_[{header.node, header.epoch}] = header.sequence;
  ++blocks_;
  is_urgent_ = is_urgent_ || block.kind == BlockKind::kEnd;
}

void HeldEvents::push(std::string_view channel, std::span<const std::uint8_t> data,
                      std::int64_t timestamp_us) {
  places_.push_back({bytes_.size(), channel.size(), data.size(), timestamp_us});
  bytes_.insert(bytes_.end(), channel.begin(), channel.end());
  bytes_.insert(bytes_.end(), data.begin(), data.end());
}

void HeldEvents::push(const RecordEvent& event, std::int64_t timestamp_us) {
  dropped_.events += event.dropped_before;
  if (bytes() >= kMostHeldForEvents && blocks_ == 0 && written_ == 0) {
    const std::size_t half = places_.size() / 2;
    dropped_.events += keep_if(
        [half](std::size_t index, const Event& old) { return index >= half || old.channel == kNoteChannel; });
  }
  if (is_caught_up() || bytes() < kMostHeldForEvents)
    push(event.channel, event.bytes, timestamp_us);
  else
    ++dropped_.events;
}

bool HeldEvents::push(const Note& note, std::int64_t timestamp_us) {
  if (!has_memory_for(note.kind)) return false;
  has_news_ = has_news_ || is_news(note.kind);
  push(kNoteChannel, encode(note), timestamp_us);
  return true;
}

// Devices fail, alarms flap and people ask for as long as a disk fails: those notes alone have no bound of
// their own.
bool HeldEvents::has_memory_for(NoteKind kind) {
  constexpr std::array kRecurring{NoteKind::kDevice,     NoteKind::kAsked,       NoteKind::kAlarmBegan,
                                  NoteKind::kAlarmEnded, NoteKind::kNodeMissing, NoteKind::kNodeThere,
                                  NoteKind::kClockSet,   NoteKind::kSlept};
  if (std::ranges::find(kRecurring, kind) == kRecurring.end()) return true;
  if (notes_ < kMostNotes) {
    ++notes_;
    return true;
  }
  ++dropped_.notes;
  return false;
}

void HeldEvents::for_each(const std::function<void(const Event&)>& call) const {
  for (std::size_t i = 0; i < places_.size(); ++i) call(at(i));
}

std::int64_t HeldEvents::keep_if(const std::function<bool(std::size_t, const Event&)>& keeps) {
  HeldEvents kept;
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (const Event event = at(i); keeps(i, event)) kept.push(event.channel, event.data, event.timestamp_us);
  const auto dropped = static_cast<std::int64_t>(places_.size() - kept.places_.size());
  bytes_ = std::move(kept.bytes_);
  places_ = std::move(kept.places_);
  return dropped;
}

void HeldEvents::go_back_to(std::int64_t durable) {
  written_ = static_cast<std::size_t>(std::max<std::int64_t>(0, durable - appended_before_));
}

void HeldEvents::begin_anew(std::int64_t appended) {
  (void)keep_if([](std::size_t, const Event& event) { return event.channel != kJournalChannel; });
  written_ = 0;
  appended_before_ = appended;
}

std::map<NodeEpoch, std::int64_t> HeldEvents::clear(std::int64_t appended) {
  bytes_.clear();
  places_.clear();
  written_ = 0;
  appended_before_ = appended;
  blocks_ = 0;
  is_urgent_ = false;
  notes_ = 0;
  has_news_ = false;
  return std::exchange(pending_, {});
}

HeldEvents::Event HeldEvents::at(std::size_t index) const {
  assert(index < places_.size());
  const Place& place = places_[index];
  const std::uint8_t* begin = bytes_.data() + place.offset;
  return {.channel = {reinterpret_cast<const char*>(begin), place.channel_bytes},
          .data = {begin + place.channel_bytes, place.data_bytes},
          .timestamp_us = place.timestamp_us};
}

}  // namespace roadbalance
