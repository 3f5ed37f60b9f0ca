#include <algorithm>
#include <cstdio>

#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "host/recorder/manifest.hpp"
#include "host/recorder/record_keeper.hpp"

namespace roadbalance {
namespace {

using std::chrono::seconds;
constexpr std::chrono::milliseconds kDutyPeriod{500};
constexpr seconds kClockPeriod{10};
constexpr seconds kJournalPeriod{1};

std::string in_words(double seconds_left) {
  char text[64];
  std::snprintf(text, sizeof text, "%.0f minutes", seconds_left / 60.0);
  return text;
}

}  // namespace

void RecordKeeper::do_duties(WallTime now) {
  if (now < duties_at_) return;
  duties_at_ = now + kDutyPeriod;
  watch_space(now);
  if (!segment_is_open_ || !is_caught_up()) return;
  if (now >= journal_at_) {
    journal_at_ = now + kJournalPeriod;
    keep_journal();
  }
  if (now < clock_note_at_) return;
  clock_note_at_ = now + kClockPeriod;
  note(NoteKind::kClock, 0, 0, "");
}

// Those with new blocks, and those that have lost more since their last entry: behind their last block, too.
std::vector<NodeEpoch> RecordKeeper::journal_due() const {
  std::vector<NodeEpoch> due = journal_.due();
  if (!segment_is_open_) return due;  // a segment for counts alone would be much
  for (const auto& [key, said] : journalled_)
    if (const auto node = counters_.node.find(key);
        node != counters_.node.end() && node->second != said && std::ranges::find(due, key) == due.end())
      due.push_back(key);
  return due;
}

void RecordKeeper::keep_journal() {
  for (const NodeEpoch& key : journal_due()) {
    Journal entry = journal_.take(key.first, key.second);
    entry.time_us = stamp_.time_us;
    if (const auto node = counters_.node.find(key); node != counters_.node.end())
      entry.node_losses = node->second;
    journalled_[key] = entry.node_losses;
    entry.refused = counters_.refused;
    entry.rivals = counters_.rivals;
    entry.unsent = counters_.unsent;
    entry.disk_failures = health_.failures();
    held_.push(kJournalChannel, encode(entry), stamp_.time_us);
  }
}

void RecordKeeper::watch_space(WallTime now) {
  if (lies_elsewhere()) return;  // another disk's room
  const std::int64_t free = disk_.free_bytes(folder().c_str());
  // The ballast's part of the reserve is there already.
  on_space(space_.take(free < 0 ? free : free + (ballast_.is_taken() ? ballast_.bytes() : 0), bytes_recorded_,
                       now));
  if (!fallback_ && free > options_.reserve_bytes && !space_.full()) ballast_.take();
}

void RecordKeeper::on_space(SpaceWatch::Event event) {
  switch (event) {
    case SpaceWatch::Event::kNone:
      return;
    case SpaceWatch::Event::kWarning:
      note(NoteKind::kDiskLow, static_cast<std::int64_t>(space_.seconds_left()), space_.usable_bytes(), "");
      warnings_.push_back("the disk will be full in " + in_words(space_.seconds_left()));
      return;
    case SpaceWatch::Event::kFull:
      note(NoteKind::kDiskFull, space_.usable_bytes(), 0, "");
      warnings_.push_back("the disk is full: the nodes keep what they measure until there is space");
      return;
    case SpaceWatch::Event::kFree:
      note(NoteKind::kDiskFree, space_.usable_bytes(), 0, "");
      warnings_.push_back("there is space again: recording goes on");
      return;
  }
}

// Only what the disk takes brings the next piece: what fails is tried again after the next commit.
void RecordKeeper::keep_house() {
  if (house_is_due_)
    house_is_due_ = !lies_elsewhere() && (writer_->tidy() || list_finished() || delete_segment_told());
}

// The manifest is for people and for transfer: one that cannot be written now is written with the next
// segment.
bool RecordKeeper::list_finished() {
  const int last = writer_->segment() - (segment_is_open_ ? 1 : 0);
  if (last <= listed_) return false;
  try {
    write_manifest(folder(), last, disk_);
    listed_ = last;
    if (options_.keep_bytes > 0) choose_segments_to_delete();
    return true;
  } catch (const std::system_error& error) {
    warnings_.push_back(error.what());
    return false;
  }
}

// The note comes first, and only when it is on the disk the segment goes: what is missing has been said.
void RecordKeeper::choose_segments_to_delete() {
  const auto sizes = read_manifest(folder(), disk_);
  const auto size_of = [&](int number) { return sizes.find(segment_path({}, number).string()); };
  const std::vector<int> numbers = segment_numbers(folder(), disk_);
  std::uint64_t total = 0;  // of what is there: that one that is listed is missing must cost no other
  for (const int number : numbers)
    if (const auto size = size_of(number); size != sizes.end()) total += size->second;
  for (const int number : numbers) {
    const auto size = size_of(number);
    if (total <= static_cast<std::uint64_t>(options_.keep_bytes) || number > listed_ || size == sizes.end())
      return;
    total -= size->second;
    if (!to_delete_.insert(number).second) continue;
    deletion_is_told_ = false;
    note(NoteKind::kSegmentDeleted, number, static_cast<std::int64_t>(size->second), "");
  }
}

// The manifest goes first, so that it lists nothing that is gone.
bool RecordKeeper::delete_segment_told() {
  if (to_delete_.empty() || !deletion_is_told_) return false;
  const int number = *to_delete_.begin();
  try {
    if (read_manifest(folder(), disk_).contains(segment_path(folder(), number).filename().string()))
      write_manifest(folder(), listed_, disk_, to_delete_);
    delete_segment(folder(), number, disk_);
    to_delete_.erase(number);
    ++segments_deleted_;
    return true;
  } catch (const std::system_error& error) {
    warnings_.push_back(error.what());  // again after the next commit
    return false;
  }
}

}  // namespace roadbalance
