#include <cerrno>
#include <stdexcept>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "host/recorder/continued_folders.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recorder/preamble.hpp"
#include "host/recorder/record_keeper.hpp"

namespace roadbalance {
namespace {

bool holds_segments(const std::filesystem::path& folder, Disk& disk) {
  return !folder.empty() && is_folder(folder, disk) && !segment_numbers(folder, disk).empty();
}

// Blocks that stand in the first folder, perhaps in the page cache only, and that nodes may have let go of.
// True if there were any.  The journal begins behind them: a reader begins it anew at the note of the start.
bool write_unsure(const std::vector<UnsureBlock>& unsure, RecordWriter& writer) {
  const std::int64_t before = writer.appended();
  for (const auto& [block, timestamp_us] : unsure) {
    const auto known = writer.holds().epoch.find({block.header.node, block.header.epoch});
    const std::int64_t held = known == writer.holds().epoch.end() ? 0 : known->second.position.contiguous;
    if (block.header.sequence <= held) continue;
    writer.append(block, timestamp_us);
  }
  if (writer.appended() == before) return false;
  writer.sync();
  return true;
}

}  // namespace

// A record goes from one folder to the other once and never back: its order stays the folders' order.
void RecordKeeper::open_folders() {
  const bool fallback_is_used = holds_segments(options_.fallback, disk_);
  fallback_ = goes_on_in_fallback(options_.folder, options_.fallback, disk_) ||
              (fallback_is_used && holds_rest_of(options_.folder, options_.fallback, disk_));
  RecordState before;
  std::vector<UnsureBlock> unsure;
  try {
    open_first();
    before = writer_->holds();
    // The first that is written: where the disk is full or read-only all else could be read.
    if (!fallback_) {
      const bool begins = !path_exists(options_.folder / kIncarnationFile, disk_);
      store_incarnation();
      if (fallback_is_used && begins) (void)disk_.unlink((options_.folder / kIncarnationFile).c_str());
      if (fallback_is_used) refuse_fallback(options_.fallback, disk_);
    }
  } catch (const std::system_error& error) {
    if (options_.fallback.empty()) throw;
    if (!fallback_) warnings_.push_back(error.what());
    fallback_ = true;
    before = held_by_first(unsure);
  }
  if (!fallback_) return;
  open(options_.fallback, std::move(before));
  store_incarnation();
  keep_cut_tail();
  warnings_.push_back("recording goes on in " + options_.fallback.string());
  segment_is_open_ = write_unsure(unsure, *writer_);
  appended_before_ = writer_->appended();
  say_where_it_goes_on();
}

bool RecordKeeper::is_known_and_missing() const {
  return options_.continues && !path_exists(options_.folder / kIncarnationFile, disk_);
}

// On a disk that is full to the last byte the ballast of an earlier run gives way first; it is ours, for
// there is space to be found wanting only behind the lock.
void RecordKeeper::open_first() {
  if (is_known_and_missing())
    throw std::system_error(ENOENT, std::generic_category(),
                            "recording " + options_.folder.string() + " (mount its disk)");
  try {
    open(options_.folder, {});
  } catch (const std::system_error& error) {
    if (error.code() != std::errc::no_space_on_device || !ballast_.remove_old()) throw;
    open(options_.folder, {});
  }
  keep_cut_tail();
  (void)ballast_.remove_old();
}

// Told of once recording begins, which may be in the other folder.
void RecordKeeper::keep_cut_tail() {
  if (const auto& cut = writer_->cut_tail()) cut_tails_.push_back(*cut);
}

// Of a folder that cannot be gone on with, as far as it can be read.  For what cannot, and was not just
// passed over, a gap stands in the fallback, and rb recover puts both together.
RecordState RecordKeeper::held_by_first(std::vector<UnsureBlock>& unsure) {
  RescueDisk readable(disk_);
  for (Disk* disk : {&disk_, static_cast<Disk*>(&readable)}) try {
      return read_state(options_.folder, *disk, {}, &unsure);
    } catch (const std::system_error& error) {
      if (disk == &disk_)
        warnings_.push_back("of what " + options_.folder.string() +
                            " holds counts only what can be read: " + error.what());
      unsure.clear();
    }
  return {};
}

void RecordKeeper::store_incarnation() {
  if (stamp_.incarnation == 0)
    stamp_.incarnation = next_incarnation(folder(), options_.least_incarnation, disk_);
  else
    keep_incarnation(folder(), stamp_.incarnation, disk_);
}

// Until the new one is good the old one stays.
void RecordKeeper::open(const std::filesystem::path& folder, RecordState before) {
  RecordWriter::Options where{.folder = folder, .segment_bytes = options_.segment_bytes};
  RecordWriter writer(std::move(where), disk_, std::move(before));
  writer.set_preamble([](const RecordState& holds) { return make_preamble(holds); });
  const auto there = disk_.identity(folder.c_str());
  if (!there) throw std::system_error(errno, std::generic_category(), "stat " + folder.string());
  // Before anything is in the fallback: else it could be taken for another drive's.
  if (folder != options_.folder) write_continues(options_.folder, folder, disk_);
  if (writer_)
    *writer_ = std::move(writer);
  else
    writer_.emplace(std::move(writer));
  appended_before_ = -static_cast<std::int64_t>(written_);
  device_ = there->device;
}

void RecordKeeper::go_to_fallback(WallTime now) {
  if (fallback_ || options_.fallback.empty()) return;
  const bool lay_elsewhere = lies_elsewhere();
  try {
    open(options_.fallback, writer_->holds());
  } catch (const std::exception& error) {
    warnings_.push_back(std::string("the fallback folder cannot be used: ") + error.what());
    return;
  }
  fallback_ = true;
  try {
    store_incarnation();
  } catch (const std::system_error& error) {
    warnings_.push_back(error.what());
  }
  hold_anew();
  health_.retry(now);
  note(NoteKind::kFallback, 0, 0, options_.fallback.string());
  warnings_.push_back("recording goes on in " + options_.fallback.string());
  if (!lay_elsewhere) say_where_it_goes_on();  // else another disk would be told
}

// What no node was told to be durable begins this one, and its journal: some of it may be in the folder
// before, or may have been.
void RecordKeeper::hold_anew() {
  const HeldEvents before = std::exchange(held_, {});
  journal_ = {};
  journalled_.clear();
  SealedBlock block;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const HeldEvents::Event event = before.at(i);
    if (event.channel == kJournalChannel) continue;
    held_.push(event.channel, event.data, event.timestamp_us);
    if (event.channel.starts_with(kBlockChannels) && accept(event.data, block) == Refusal::kNone)
      journal_.add(block);
  }
  written_ = 0;
  appended_before_ = writer_->appended();
  segment_is_open_ = false;
  listed_ = 0;
  to_delete_.clear();
}

// For a start without --fallback; a folder that cannot be written to cannot be told.
void RecordKeeper::say_where_it_goes_on() {
  try {
    if (is_known_and_missing()) return;  // what is there is another disk's
    write_continued_in(options_.folder, options_.fallback, disk_);
  } catch (const std::system_error&) {
  }
}

// A file that has no name any more takes all that is written to it, and keeps nothing.  A file of a disk that
// was unmounted while it was open keeps it, and nobody sees it.  Asked before, too: what was synced there
// could not be told from what is on a copy that takes its place.
void RecordKeeper::sync() {
  require_its_place();
  writer_->sync();
  require_its_place();
}

void RecordKeeper::require_its_place() const {
  if (!segment_is_open_ || writer_->is_at_its_place()) return;
  throw std::system_error(ENODEV, std::generic_category(),
                          "recording " + folder().string() + " was removed or its disk unmounted");
}

bool RecordKeeper::lies_elsewhere() const {
  const auto there = disk_.identity(folder().c_str());
  return there ? there->device != device_ : errno == ENOENT;
}

// Asked while a file of it is open, so that no other disk has its number.
bool RecordKeeper::is_its_disk_there() const {
  for (std::filesystem::path path = full_name(folder());; path = path.parent_path()) {
    const auto there = disk_.identity(path.c_str());
    if (there) return there->device == device_;
    if (errno != ENOENT || path == path.parent_path()) return false;
  }
}

bool RecordKeeper::holds_this_recording() const {
  if (fallback_) return holds_rest_of(options_.folder, options_.fallback, disk_);
  try {
    return stored_incarnation(options_.folder, disk_) >= stamp_.incarnation;  // raised while it runs
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error&) {
    return false;
  }
}

// Where a disk was mounted lies a folder of another one, or none.  It would take all, and show it to nobody
// once the disk is mounted again.
void RecordKeeper::come_back() {
  const auto there = disk_.identity(folder().c_str());
  if (!there && errno == ENOENT)
    throw std::system_error(ENOENT, std::generic_category(),
                            "recording " + folder().string() +
                                " (mount its disk, or, if none was mounted, make the folder again)");
  if (!there) throw std::system_error(errno, std::generic_category(), "stat " + folder().string());
  const bool is_same_disk = there->device == device_, is_this = holds_this_recording();
  if ((is_same_disk || is_this) && writer_->take_again()) {
    device_ = there->device;
    is_removed_ = false;
    return;
  }
  if (is_removed_ && is_same_disk && (is_this || segment_numbers(folder(), disk_).empty()))
    return begin_anew();
  throw std::system_error(ENODEV, std::generic_category(),
                          "recording " + folder().string() +
                              " (mount the disk that it is on; or stop, and start another recording)");
}

// Somebody has removed what was there: the rest is recorded.
void RecordKeeper::begin_anew() {
  store_incarnation();
  try {
    open(folder(), writer_->holds());
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw std::system_error(EBUSY, std::generic_category(), error.what());
  }
  hold_anew();
  is_removed_ = false;
  is_lost_ = true;
}

}  // namespace roadbalance
