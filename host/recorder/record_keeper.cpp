#include "host/recorder/record_keeper.hpp"

#include <algorithm>
#include <cerrno>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/link/planted.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {
namespace {

// Nothing lies at the paths any more, or something else.
bool is_of_place(const std::error_code& code) {
  return code == std::errc::no_such_file_or_directory || code == std::errc::no_such_device;
}

// While the disk fails the nodes' blocks stay bounded by credit; other events have no such bound.
constexpr std::size_t kMostHeldForEvents = std::size_t{16} << 20;

}  // namespace

RecordKeeper::RecordKeeper(Disk& disk, KeeperOptions options)
    : disk_(disk),
      options_(std::move(options)),
      space_(options_.reserve_bytes),
      ballast_(disk, options_.folder, options_.ballast_bytes) {
  open_folders();
  recovered_ = writer_->holds();
  sums_ = EpochSums(recovered_);
}

void RecordKeeper::begin() {
  note(NoteKind::kStarted, writer_->segment() + (segment_is_open_ ? 0 : 1), 0, "");
  for (const RecordWriter::CutTail& cut : cut_tails_) {
    const int segment = segment_of_file(cut.segment.filename().string(), ".lcm").value_or(0);
    const bool is_here = cut.segment == segment_path(folder(), segment);
    note(NoteKind::kTailCut, segment, static_cast<std::int64_t>(cut.cut),
         (is_here ? cut.tail.filename() : cut.tail).string());
  }
}

void RecordKeeper::set_clocks(std::int64_t utc_us, std::int64_t host_ns) {
  stamp_.time_us = utc_us;
  stamp_.host_ns = host_ns;
}

void RecordKeeper::append(const Delivery& delivery, WallTime now) {
  SealedBlock declared;
  const auto* block = std::get_if<SealedBlock>(&delivery);
  if (!block) {
    roadbalance::seal(std::get<GapBlock>(delivery), declared);
    block = &declared;
  }
  const BlockHeader& header = block->header;
  if (pending_.empty()) oldest_ = now;
  pending_[{header.node, header.epoch}] = header.sequence;
  ++held_blocks_;
  bytes_recorded_ += block->size;
  urgent_ = urgent_ || block->kind == BlockKind::kEnd;
  const bool at_once = write_held(now) && may_write(now);
  journal_.add(*block);
  held_.push(block_channel(header.node, block->kind), block->bytes(), stamp_.time_us);
  if (at_once && attempt(now, [&] { writer_->append(*block, stamp_.time_us); })) {
    ++written_;
    segment_is_open_ = true;
  }
  check_sum(*block);
}

// What the end says against what was given to be recorded, whose blocks' own CRCs are all good.
void RecordKeeper::check_sum(const SealedBlock& block) {
  sums_.take(block);
  if (block.kind != BlockKind::kEnd || sums_.agrees(block).value_or(true)) return;
  note(NoteKind::kEndContradicts, block.header.node, block.header.sequence, "");
  warnings_.push_back("node " + std::to_string(block.header.node) +
                      ": the blocks received are not those that its end sums up; rb verify says more");
}

void RecordKeeper::append(const RecordEvent& event, WallTime) {
  events_dropped_ += event.dropped_before;
  if (held_.bytes() >= kMostHeldForEvents && held_blocks_ == 0 && written_ == 0)
    events_dropped_ += held_.drop_older_half(kNoteChannel);
  if (is_caught_up() || held_.bytes() < kMostHeldForEvents)
    held_.push(event.channel, event.bytes, stamp_.time_us);
  else
    ++events_dropped_;
}

// For notes alone no recording begins, but for marks, which somebody waits for.  One that has blocks gets a
// segment for them: behind the seal that a lost supply asks for no block may come any more.  So do those that
// say what is wrong with the disk: nothing else shows that it works again while no credit lets blocks come.
bool RecordKeeper::may_write(WallTime now) const {
  const bool has_mark = last_mark_ > last_durable_mark_, has_news = has_news_ && has_blocks();
  return (segment_is_open_ || held_blocks_ > 0 || has_mark || has_news ||
          (!wants_credit() && held_.size() > 0)) &&
         health_.may_try(now);
}

template <typename Call>
bool RecordKeeper::attempt(WallTime now, Call&& call) {
  try {
    call();
    return true;
  } catch (const std::system_error& error) {
    fail(error, now);
    return false;
  }
}

void RecordKeeper::fail(const std::system_error& error, WallTime now) {
  const bool was_failing = health_.failing();
  health_.fail(now);
  house_is_due_ = false;
  last_failure_ = error.what();
  const int segment = writer_->segment();
  const bool no_space = error.code().value() == ENOSPC || error.code().value() == EDQUOT;
  const bool lets_go = (health_.failing() && !no_space) || is_of_place(error.code());
  if (lets_go && !writer_->is_away()) is_removed_ = is_of_place(error.code()) && is_its_disk_there();
  if (writer_->has_failed() || lets_go) {
    if (lets_go)
      writer_->let_go(stamp_);
    else
      writer_->abandon(stamp_);
    segment_is_open_ = false;
    written_ = static_cast<std::size_t>(std::max<std::int64_t>(0, writer_->durable() - appended_before_));
  }
  if (++failures_in_a_row_ <= 2) {
    note(NoteKind::kDiskFailed, error.code().value(), segment, last_failure_);
    warnings_.push_back(last_failure_ + (health_.failing() ? "; the nodes keep what they measure" : ""));
  }
  if (no_space) {
    on_space(space_.refuse(now));
    (void)ballast_.give_up();
  } else if (was_failing) {
    go_to_fallback(now);
  }
}

bool RecordKeeper::write_held(WallTime now) {
  if (is_caught_up() && !writer_->is_away()) return true;
  if (!may_write(now)) return false;
  return attempt(now, [&] {
    if (writer_->is_away()) come_back();
    for (; written_ < held_.size(); ++written_) {
      const HeldEvents::Event event = held_.at(written_);
      writer_->append(event.channel, event.data, event.timestamp_us);
      segment_is_open_ = true;
    }
  });
}

bool RecordKeeper::commit_is_due(WallTime now) const {
  if (!pending_.empty() && (urgent_ || held_.bytes() >= options_.commit_bytes || !is_caught_up() ||
                            now >= oldest_ + options_.commit_period))
    if (health_.may_try(now)) return true;
  return (pending_.empty() || !health_.may_try(now)) && now >= duties_at_;
}

std::chrono::milliseconds RecordKeeper::time_left(WallTime now) const {
  if (pending_.empty() || !health_.may_try(now)) return options_.commit_period;
  return std::chrono::ceil<std::chrono::milliseconds>(oldest_ + options_.commit_period - now);
}

std::vector<DurableMark> RecordKeeper::commit(WallTime now) {
  do_duties(now);
  if (held_.size() == 0) return {};
  // After a first failure at once again, in a new segment.
  for (int attempts = 0; attempts < 2 && may_write(now); ++attempts)
    if (write_held(now) && (planted(PlantedFault::kAckBeforeSync) || attempt(now, [this] { sync(); })))
      return all_is_durable();
  return {};
}

std::vector<DurableMark> RecordKeeper::all_is_durable() {
  std::vector<DurableMark> marks;
  for (const auto& [key, sequence] : pending_) marks.push_back({key.first, key.second, sequence});
  pending_.clear();
  held_.clear();
  written_ = 0;
  appended_before_ = writer_->appended();
  held_blocks_ = 0;
  urgent_ = false;
  if (failures_in_a_row_ > 1 || is_lost_)
    warnings_.push_back(
        std::exchange(is_lost_, false)
            ? "the disk writes again; what had been recorded before is not in its folder any more"
            : "the disk writes again; nothing was lost");
  notes_held_ = 0;
  has_news_ = false;
  declare_dropped(std::exchange(events_dropped_, 0), "measurements of the nodes' clocks");
  declare_dropped(std::exchange(notes_dropped_, 0), "notes of devices, of alarms and of what was asked");
  last_durable_mark_ = last_mark_;
  failures_in_a_row_ = 0;
  health_.succeed();
  space_.wrote();
  house_is_due_ = true;
  deletion_is_told_ = !to_delete_.empty();
  return marks;
}

std::vector<DurableMark> RecordKeeper::seal(WallTime now) {
  health_.retry(now);  // power or program may be gone before a failing disk's next turn
  keep_journal();
  auto marks = commit(now);
  while (house_is_due_) keep_house();
  // That may have chosen segments to delete, of which a note tells.
  if (held_blocks_ == 0 && held_.size() > 0) (void)commit(now);
  while (house_is_due_) keep_house();
  if (held_.size() == 0 && segment_is_open_ && attempt(now, [this] {
        require_its_place();
        writer_->close();
      })) {
    segment_is_open_ = false;
    (void)list_finished();
  }
  return marks;
}

// What is pending stands in the record before the note that says so.
std::int64_t RecordKeeper::epochs_held() const {
  const auto& written = writer_->holds().epoch;
  return std::ssize(written) + std::ranges::count_if(pending_, [&written](const auto& one) {
           return !written.contains(one.first);
         });
}

std::vector<DurableMark> RecordKeeper::close(WallTime now) {
  if (segment_is_open_ || held_blocks_ > 0 || last_mark_ > last_durable_mark_ || has_blocks())
    note(NoteKind::kStopped, epochs_held(), last_mark_, "");
  auto marks = seal(now);
  if (has_news_ && has_blocks() && held_blocks_ == 0)
    warnings_.push_back("the last notes are not on the disk: " + last_failure_);
  (void)ballast_.give_up();
  return marks;
}

RecorderState RecordKeeper::state() const {
  if (space_.full()) return RecorderState::kDiskFull;
  return health_.failing() ? RecorderState::kDiskFailing : RecorderState::kRecording;
}

std::optional<std::string> RecordKeeper::failure() const {
  if (held_blocks_ == 0) return std::nullopt;
  return last_failure_;
}

void RecordKeeper::fill(RecorderStatus& status) const {
  status.state = state();
  status.fault = status.state == RecorderState::kDiskFailing ? last_failure_ : "";
  status.incarnation = stamp_.incarnation;
  status.fallback = fallback_;
  status.segment = writer_->segment();
  status.bytes_recorded = bytes_recorded_;
  status.bytes_free = space_.usable_bytes();
  status.seconds_left = space_.seconds_left();
  status.waiting_blocks = held_blocks_;
  status.disk_failures = health_.failures();
  status.segments_deleted = segments_deleted_;
  status.marks = durable_marks();
}

}  // namespace roadbalance
