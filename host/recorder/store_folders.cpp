#include "host/recorder/store_folders.hpp"

#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recording/continued_folders.hpp"
#include "host/recording/preamble.hpp"

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

StoreFolders::StoreFolders(Disk& disk, const StoreOptions& options, Ballast& ballast,
                           std::vector<std::string>& warnings)
    : disk_(disk), options_(options), ballast_(ballast), warnings_(warnings) {
  open_folders();
}

void StoreFolders::append(const SealedBlock& block, std::int64_t timestamp_us) {
  writer_->append(block, timestamp_us);
  segment_is_open_ = true;
}

void StoreFolders::append(std::string_view channel, std::span<const std::uint8_t> data,
                          std::int64_t timestamp_us) {
  writer_->append(channel, data, timestamp_us);
  segment_is_open_ = true;
}

void StoreFolders::open_folders() {
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
  say_where_it_goes_on();
}

bool StoreFolders::is_known_and_missing() const {
  return options_.continues && !path_exists(options_.folder / kIncarnationFile, disk_);
}

// On a disk that is full to the last byte the ballast of an earlier run gives way first; it is ours, for
// there is space to be found wanting only behind the lock.
void StoreFolders::open_first() {
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

// Noted once recording begins, which may be in the other folder.
void StoreFolders::keep_cut_tail() {
  if (const auto& cut = writer_->cut_tail()) cut_tails_.push_back(*cut);
}

// For a folder that cannot be gone on with, as far as it can be read.  A gap in the fallback stands for the
// rest, and rb recover puts both together.
RecordState StoreFolders::held_by_first(std::vector<UnsureBlock>& unsure) {
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

void StoreFolders::store_incarnation() {
  if (incarnation_ == 0)
    incarnation_ = next_incarnation(folder(), options_.least_incarnation, disk_);
  else
    keep_incarnation(folder(), incarnation_, disk_);
}

// Until the new one is good the old one stays.
void StoreFolders::open(const std::filesystem::path& folder, RecordState before) {
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
  device_ = there->device;
}

bool StoreFolders::go_to_fallback() {
  if (fallback_ || options_.fallback.empty()) return false;
  const bool lay_elsewhere = lies_elsewhere();
  try {
    open(options_.fallback, writer_->holds());
  } catch (const std::exception& error) {
    warnings_.push_back(std::string("the fallback folder cannot be used: ") + error.what());
    return false;
  }
  fallback_ = true;
  segment_is_open_ = false;
  try {
    store_incarnation();
  } catch (const std::system_error& error) {
    warnings_.push_back(error.what());
  }
  warnings_.push_back("recording goes on in " + options_.fallback.string());
  if (!lay_elsewhere) say_where_it_goes_on();  // else it would be written to another disk
  return true;
}

// For a start without --fallback; a folder that cannot be written to stays without.
void StoreFolders::say_where_it_goes_on() {
  try {
    if (is_known_and_missing()) return;  // what is there is another disk's
    write_continued_in(options_.folder, options_.fallback, disk_);
  } catch (const std::system_error&) {
  }
}

// Checked before, too: data synced there could not be distinguished from data on a copy that takes its place.
void StoreFolders::sync() {
  require_its_place();
  writer_->sync();
  require_its_place();
}

void StoreFolders::close() {
  require_its_place();
  writer_->close();
  segment_is_open_ = false;
}

bool StoreFolders::give_up(const FailurePolicy::Decision& decision, const Note& stamp) {
  if (decision.lets_go && !writer_->is_away()) is_removed_ = decision.has_no_place && is_its_disk_there();
  if (!writer_->has_failed() && !decision.lets_go) return false;
  if (decision.lets_go)
    writer_->let_go(stamp);
  else
    writer_->abandon(stamp);
  segment_is_open_ = false;
  return true;
}

void StoreFolders::require_its_place() const {
  if (!segment_is_open_ || writer_->is_at_its_place()) return;
  throw std::system_error(ENODEV, std::generic_category(),
                          "recording " + folder().string() + " was removed or its disk unmounted");
}

bool StoreFolders::lies_elsewhere() const {
  const auto there = disk_.identity(folder().c_str());
  return there ? there->device != device_ : errno == ENOENT;
}

// Asked while a file of it is open, so that no other disk has its number.
bool StoreFolders::is_its_disk_there() const {
  for (std::filesystem::path path = full_name(folder());; path = path.parent_path()) {
    const auto there = disk_.identity(path.c_str());
    if (there) return there->device == device_;
    if (errno != ENOENT || path == path.parent_path()) return false;
  }
}

bool StoreFolders::holds_this_recording() const {
  if (fallback_) return holds_rest_of(options_.folder, options_.fallback, disk_);
  try {
    return stored_incarnation(options_.folder, disk_) >= incarnation_;  // raised while it runs
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error&) {
    return false;
  }
}

bool StoreFolders::come_back() {
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
    return false;
  }
  if (is_removed_ && is_same_disk && (is_this || segment_numbers(folder(), disk_).empty())) {
    begin_anew();
    return true;
  }
  throw std::system_error(ENODEV, std::generic_category(),
                          "recording " + folder().string() +
                              " (mount the disk that it is on; or stop, and start another recording)");
}

// Somebody has removed what was there: the rest is recorded.
void StoreFolders::begin_anew() {
  store_incarnation();
  try {
    open(folder(), writer_->holds());
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw std::system_error(EBUSY, std::generic_category(), error.what());
  }
  segment_is_open_ = false;
  is_removed_ = false;
}

}  // namespace roadbalance
