#include "host/recorder/recording_store.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/link/planted.hpp"
#include "common/record/segment.hpp"
#include "host/recorder/clock_change.hpp"

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

RecordingStore::RecordingStore(Disk& disk, StoreOptions options)
    : disk_(disk),
      options_(std::move(options)),
      ballast_(disk, options_.folder, options_.ballast_bytes),
      folders_(disk, options_, ballast_, warnings_),
      recovered_(folders_.holds()),
      held_(folders_.appended()),
      space_(options_.reserve_bytes),
      retention_(
          disk, options_.keep_bytes,
          [this](int segment, std::int64_t bytes) { note(NoteKind::kSegmentDeleted, segment, bytes, ""); },
          warnings_),
      sums_(recovered_) {
  stamp_.incarnation = folders_.incarnation();
}

void RecordingStore::begin() {
  note(NoteKind::kStarted, folders_.last_finished_segment() + 1, 0, "");
  for (const RecordWriter::CutTail& cut : cut_tails()) {
    const int segment = segment_of_file(cut.segment.filename().string(), ".lcm").value_or(0);
    const bool is_here = cut.segment == segment_path(folder(), segment);
    note(NoteKind::kTailCut, segment, static_cast<std::int64_t>(cut.cut),
         (is_here ? cut.tail.filename() : cut.tail).string());
  }
}

void RecordingStore::set_clocks(std::int64_t utc_us, std::int64_t host_ns, MachineClock::duration slept) {
  const bool is_first = stamp_.time_us == 0;
  const std::int64_t change_us = (utc_us - stamp_.time_us) - (host_ns - stamp_.host_ns) / 1000;
  const std::int64_t slept_us =
      std::chrono::duration_cast<std::chrono::microseconds>(slept - std::exchange(slept_, slept)).count();
  stamp_.time_us = utc_us;
  stamp_.host_ns = host_ns;
  if (is_first || !options_.notes_clocks) return;
  if (slept_us > 0) {
    note(NoteKind::kSlept, slept_us, 0, "");
    warnings_.push_back("this computer was suspended for " + std::to_string(slept_us / 1'000'000) +
                        " s: what was not measured is declared as a gap");
  }
  if (std::abs(change_us) < kClockSet_us) return;
  note(NoteKind::kClockSet, change_us, 0, "");
  warnings_.push_back("the wall clock was set by " + std::to_string(change_us / 1'000'000) +
                      " s: times of the recording are put right by that");
}

void RecordingStore::append(const Delivery& delivery, WallTime now) {
  SealedBlock declared;
  const auto* block = std::get_if<SealedBlock>(&delivery);
  if (!block) {
    roadbalance::seal(std::get<GapBlock>(delivery), declared);
    block = &declared;
  }
  held_.await(*block, now);
  if (block->kind == BlockKind::kScan && first_ == First::kToCome) first_ = First::kWaits;
  bytes_recorded_ += block->size;
  const bool at_once = write_held(now) && may_write(now);
  journal_.add(*block);
  held_.push(block_channel(block->header.node, block->kind), block->bytes(), stamp_.time_us);
  if (at_once && attempt(now, [&] { folders_.append(*block, stamp_.time_us); })) held_.advance();
  check_sum(*block);
}

// The end's sum against that of the blocks given to be recorded, whose own CRCs are all good.
void RecordingStore::check_sum(const SealedBlock& block) {
  sums_.take(block);
  if (block.kind != BlockKind::kEnd || sums_.agrees(block).value_or(true)) return;
  note(NoteKind::kEndContradicts, block.header.node, block.header.sequence, "");
  warnings_.push_back("node " + std::to_string(block.header.node) +
                      ": the blocks received are not those that its end sums up; rb verify says more");
}

void RecordingStore::append(const RecordEvent& event, WallTime) {
  held_.push(event, stamp_.time_us);
}

void RecordingStore::note(NoteKind kind, std::int64_t a, std::int64_t b, std::string text,
                          std::chrono::nanoseconds age) {
  Note note = stamp_;
  note.time_us -= age.count() / 1000;
  note.host_ns -= age.count();
  note.kind = kind;
  note.a = a;
  note.b = b;
  note.text = std::move(text);
  if (held_.push(note, stamp_.time_us) && kind == NoteKind::kMark) last_mark_ = a;
}

// For notes alone no recording begins, but for marks, for which a person waits.  One that has blocks gets a
// segment for them: behind the seal that a lost supply asks for no block may come any more.  So do notes of
// what is wrong with the disk: nothing else shows that it works again while no credit lets blocks come.
bool RecordingStore::may_write(WallTime now) const {
  const bool has_news = held_.has_news() && has_blocks();
  return (folders_.has_open_segment() || held_.blocks() > 0 || has_new_mark() || has_news ||
          (!wants_credit() && !held_.empty())) &&
         failures_.may_try(now);
}

template <typename Call>
bool RecordingStore::attempt(WallTime now, Call&& call) {
  try {
    call();
    return true;
  } catch (const std::system_error& error) {
    fail(error, now);
    return false;
  }
}

void RecordingStore::fail(const std::system_error& error, WallTime now) {
  const FailurePolicy::Decision decision = failures_.fail(error, now);
  maintenance_is_due_ = false;
  const int segment = folders_.segment();
  if (folders_.give_up(decision, stamp_)) held_.go_back_to(folders_.durable());
  if (decision.is_reported) {
    note(NoteKind::kDiskFailed, error.code().value(), segment, failures_.why());
    warnings_.push_back(failures_.why() +
                        (failures_.is_failing() ? "; the nodes keep what they measure" : ""));
  }
  if (decision.is_full) {
    on_space(space_.refuse(now));
    (void)ballast_.give_up();
  } else if (decision.goes_elsewhere && folders_.go_to_fallback()) {
    hold_anew();
    failures_.retry(now);
    note(NoteKind::kFallback, 0, 0, options_.fallback.string());
  }
}

bool RecordingStore::write_held(WallTime now) {
  if (held_.is_caught_up() && !folders_.is_away()) return true;
  if (!may_write(now)) return false;
  return attempt(now, [&] {
    if (folders_.is_away() && folders_.come_back()) {
      hold_anew();
      is_lost_ = true;
    }
    for (; !held_.is_caught_up(); held_.advance()) {
      const HeldEvents::Event event = held_.next();
      folders_.append(event.channel, event.data, event.timestamp_us);
    }
  });
}

// Events whose durability no node has heard of begin this folder, and its journal: some of them may be in the
// folder before, or may have been.
void RecordingStore::hold_anew() {
  held_.begin_anew(folders_.appended());
  journal_.begin_anew();
  SealedBlock block;
  held_.for_each([&](const HeldEvents::Event& event) {
    if (event.channel.starts_with(kBlockChannels) && accept(event.data, block) == Refusal::kNone)
      journal_.add(block);
  });
  retention_.begin_anew();
}

bool RecordingStore::commit_is_due(WallTime now) const {
  const bool waits = held_.blocks() > 0;
  const bool is_awaited = options_.first_at_once && first_ == First::kWaits;
  if (waits && (is_awaited || held_.is_urgent() || held_.bytes() >= options_.commit_bytes ||
                !held_.is_caught_up() || now >= held_.oldest() + options_.commit_period))
    if (failures_.may_try(now)) return true;
  return (!waits || !failures_.may_try(now)) && now >= duties_at_;
}

std::chrono::milliseconds RecordingStore::time_left(WallTime now) const {
  if (held_.blocks() == 0 || !failures_.may_try(now)) return options_.commit_period;
  return std::chrono::ceil<std::chrono::milliseconds>(held_.oldest() + options_.commit_period - now);
}

std::vector<DurableMark> RecordingStore::commit(WallTime now) {
  do_duties(now);
  if (held_.empty()) return {};
  // After a first failure at once again, in a new segment.
  for (int attempts = 0; attempts < 2 && may_write(now); ++attempts)
    if (write_held(now) &&
        (planted(PlantedFault::kAckBeforeSync) || attempt(now, [this] { folders_.sync(); })))
      return all_is_durable();
  return {};
}

std::vector<DurableMark> RecordingStore::all_is_durable() {
  std::vector<DurableMark> marks;
  for (const auto& [key, sequence] : held_.clear(folders_.appended()))
    marks.push_back({key.first, key.second, sequence});
  if (first_ == First::kWaits) first_ = First::kDurable;
  const bool had_failed = failures_.succeed();
  if (had_failed || is_lost_)
    warnings_.push_back(
        std::exchange(is_lost_, false)
            ? "the disk writes again; what had been recorded before is not in its folder any more"
            : "the disk writes again; nothing was lost");
  const HeldEvents::Dropped dropped = held_.take_dropped();
  declare_dropped(dropped.events, "measurements of the nodes' clocks");
  declare_dropped(dropped.notes, "notes of devices, of alarms and of what was asked");
  last_durable_mark_ = last_mark_;
  space_.wrote();
  maintenance_is_due_ = true;
  retention_.notes_are_durable();
  return marks;
}

void RecordingStore::declare_dropped(std::int64_t count, const char* what) {
  if (count == 0) return;
  const std::string lost = std::to_string(count) + " " + what + " were not kept: no memory for more";
  note(NoteKind::kDiskFailed, 0, folders_.segment(), lost);
  warnings_.push_back(lost);
}

std::vector<DurableMark> RecordingStore::seal(WallTime now) {
  failures_.retry(now);  // power or program may be gone before a failing disk's next turn
  write_journal();
  auto marks = commit(now);
  while (maintenance_is_due_) maintain();
  // That may have chosen segments to delete, and made a note of each.
  if (held_.blocks() == 0 && !held_.empty()) (void)commit(now);
  while (maintenance_is_due_) maintain();
  if (held_.empty() && folders_.has_open_segment() && attempt(now, [this] { folders_.close(); }))
    (void)retention_.list(folder(), folders_.last_finished_segment());
  return marks;
}

// Pending epochs stand in the record before the note that counts them.
std::int64_t RecordingStore::epochs_held() const {
  const auto& written = folders_.holds().epoch;
  return std::ssize(written) + std::ranges::count_if(held_.pending(), [&written](const auto& one) {
           return !written.contains(one.first);
         });
}

std::vector<DurableMark> RecordingStore::close(WallTime now) {
  if (folders_.has_open_segment() || held_.blocks() > 0 || has_new_mark() || has_blocks())
    note(NoteKind::kStopped, epochs_held(), last_mark_, "");
  auto marks = seal(now);
  if (held_.has_news() && has_blocks() && held_.blocks() == 0)
    warnings_.push_back("the last notes are not on the disk: " + failures_.why());
  (void)ballast_.give_up();
  return marks;
}

RecorderState RecordingStore::state() const {
  if (space_.full()) return RecorderState::kDiskFull;
  return failures_.is_failing() ? RecorderState::kDiskFailing : RecorderState::kRecording;
}

std::optional<std::string> RecordingStore::failure() const {
  if (held_.blocks() == 0) return std::nullopt;
  return failures_.why();
}

void RecordingStore::fill(RecorderStatus& status) const {
  status.state = state();
  status.fault = status.state == RecorderState::kDiskFailing ? failures_.why() : "";
  status.incarnation = stamp_.incarnation;
  status.fallback = folders_.is_fallback();
  status.segment = folders_.segment();
  status.bytes_recorded = bytes_recorded_;
  status.bytes_free = space_.usable_bytes();
  status.seconds_left = space_.seconds_left();
  status.waiting_blocks = held_.blocks();
  status.disk_failures = failures_.failures();
  status.segments_deleted = retention_.deleted();
  status.marks = durable_marks();
}

void RecordingStore::do_duties(WallTime now) {
  if (now < duties_at_) return;
  duties_at_ = now + kDutyPeriod;
  watch_space(now);
  if (!folders_.has_open_segment() || !held_.is_caught_up()) return;
  if (now >= journal_at_) {
    journal_at_ = now + kJournalPeriod;
    write_journal();
  }
  if (now < clock_note_at_) return;
  clock_note_at_ = now + kClockPeriod;
  note(NoteKind::kClock, 0, 0, "");
}

// A segment for losses alone would be much.
void RecordingStore::write_journal() {
  for (const Journal& entry :
       journal_.entries(folders_.has_open_segment(), stamp_.time_us, failures_.failures()))
    held_.push(kJournalChannel, encode(entry), stamp_.time_us);
}

void RecordingStore::watch_space(WallTime now) {
  if (folders_.lies_elsewhere()) return;  // another disk's room
  const std::int64_t free = disk_.free_bytes(folder().c_str());
  // The ballast's part of the reserve is there already.
  on_space(space_.take(free < 0 ? free : free + (ballast_.is_taken() ? ballast_.bytes() : 0), bytes_recorded_,
                       now));
  if (!folders_.is_fallback() && free > options_.reserve_bytes && !space_.full()) ballast_.take();
}

void RecordingStore::on_space(SpaceWatch::Event event) {
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

// Only a step that the disk takes brings the next one: a failed one is tried again after the next commit.
void RecordingStore::maintain() {
  if (maintenance_is_due_)
    maintenance_is_due_ = !folders_.lies_elsewhere() &&
                          (folders_.tidy() || retention_.list(folder(), folders_.last_finished_segment()) ||
                           retention_.delete_one(folder()));
}

}  // namespace roadbalance
