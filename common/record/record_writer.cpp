#include "common/record/record_writer.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/link/planted.hpp"
#include "common/record/folder.hpp"
#include "common/record/log_event.hpp"
#include "common/record/record_folder.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_events.hpp"
#include "common/record/take_over.hpp"
#include "common/record/written_segment.hpp"
#include "common/types/block.hpp"

namespace roadbalance {
namespace {

// One block in so many is hit.
constexpr std::int64_t kOneIn = 97;

bool is_hit(const SealedBlock& block) {
  return block.kind == BlockKind::kScan && block.header.sequence % kOneIn == 0;
}

bool is_next(const SealedBlock& first, const SealedBlock& second) {
  return second.kind == BlockKind::kScan && second.header.node == first.header.node &&
         second.header.epoch == first.header.epoch && second.header.sequence == first.header.sequence + 1 &&
         second.header.scans == first.header.scans;
}

/// Applies the planted faults kBlockAltered and kBlocksSwapped to blocks on their way to the disk; in every
/// other build a block is given back as it came.
class AlterBlocks {
 public:
  /// The blocks to write now; valid until the next call, and as long as `block` is.
  std::span<const SealedBlock> operator()(const SealedBlock& block);

 private:
  std::span<const SealedBlock> altered(const SealedBlock& block);
  std::span<const SealedBlock> swapped(const SealedBlock& block);

  std::optional<SealedBlock> held_;
  std::array<SealedBlock, 2> given_;
};

std::span<const SealedBlock> AlterBlocks::operator()(const SealedBlock& block) {
  if (planted(PlantedFault::kBlockAltered)) return altered(block);
  if (planted(PlantedFault::kBlocksSwapped)) return swapped(block);
  return {&block, 1};
}

std::span<const SealedBlock> AlterBlocks::altered(const SealedBlock& block) {
  if (!is_hit(block)) return {&block, 1};
  ScanBlock scans = decode_scan(block);
  scans.counts[0][0] ^= 1;
  seal(scans, given_[0]);
  return {given_.data(), 1};
}

std::span<const SealedBlock> AlterBlocks::swapped(const SealedBlock& block) {
  if (!held_) {
    if (!is_hit(block)) return {&block, 1};
    held_ = block;
    return {};
  }
  given_ = {*held_, block};
  if (is_next(*held_, block)) {
    ScanBlock first = decode_scan(block);
    ScanBlock second = decode_scan(*held_);
    std::swap(first.header, second.header);
    seal(first, given_[0]);
    seal(second, given_[1]);
  }
  held_.reset();
  return given_;
}

}  // namespace

/// The segment being written and how it is followed by the next.
struct RecordWriter::State : SegmentEvents {
  /// Space is asked for in these steps, so that a short recording does not take a whole segment's.
  static constexpr std::uint64_t kReserveBytes = std::uint64_t{16} << 20;
  /// Appended events wait here for one write(2).
  static constexpr std::size_t kBufferBytes = std::size_t{256} << 10;

  State(Options with, Disk& on) : options(std::move(with)), disk(on) {}

  const Options options;
  Disk& disk;
  RecordFolder folder;
  File file;
  std::optional<WrittenSegment> written;  // the one before, until it is finished
  int segment = 0;                        // number of the current or, with no file open, of the last segment
  std::uint64_t durable_bytes = 0;        // of the segment
  std::uint64_t reserved_bytes = 0;
  std::int64_t appended = 0;
  std::int64_t durable = 0;
  bool failed = false;
  bool may_have_next = false;  // a rename that failed may have happened
  bool commit_due = false;     // the next event is to state what is durable
  Preamble preamble = [](const RecordState&) { return RecordEvents(); };
  std::vector<Note> abandoned;  // not yet noted durably
  std::map<int, std::uint64_t>
      uncut{};  // abandoned segments that take more space than what is durable of them
  std::optional<CutTail> cut;
  RecordState before_it;  // what the record continues
  RecordState holds;
  std::map<NodeEpoch, std::optional<RecordState::Epoch>> before;  // as of the last sync, where it was another
  RecordedClocks durable_clocks;
  bool clocks_changed = false;  // since the last sync
  AlterBlocks altered;

  void flush(File& into) {
    while (reserved_bytes < segment_bytes) {
      into.reserve(reserved_bytes, kReserveBytes);
      reserved_bytes += kReserveBytes;
    }
    into.write_all(buffer);
    buffer.clear();
  }

  // A call on the segment being written: if it fails there is no second one.
  template <typename Call>
  void attempt(Call&& call) {
    assert(!failed && "abandon() comes first");
    failed = true;
    call();
    failed = false;
  }

  void sync_data() {
    if (!planted(PlantedFault::kRetryFailedSync)) return file.sync_data();
    try {
      file.sync_data();
    } catch (const std::system_error&) {
      file.sync_data();
    }
  }

  void all_is_durable() {
    commit_due = durable_bytes < segment_bytes;
    durable_bytes = segment_bytes;
    durable = appended;
    before.clear();
    if (std::exchange(clocks_changed, false)) durable_clocks = holds.clocks;
  }

  void sync() {
    attempt([this] {
      flush(file);
      sync_data();
    });
    all_is_durable();
  }

  // All of it is on the disk, so that nothing of what fails here matters.
  bool tidy() {
    if (!written) return false;
    WrittenSegment last = *std::exchange(written, std::nullopt);
    try {
      last.finish(options.folder, disk);
    } catch (const std::system_error&) {
    }
    return true;
  }

  // An abandoned segment that a failing disk did not let us cut.
  bool cut_one() {
    if (uncut.empty()) return false;
    const auto [number, bytes] = *uncut.begin();
    try {
      if (!folder.is_at(options.folder) ||
          !cut_back(File::open_to_write(path(number), disk), bytes, path(number), disk))
        return false;
    } catch (const std::system_error& error) {
      if (error.code() != std::errc::no_such_file_or_directory) return false;
    }
    uncut.erase(number);
    return true;
  }

  // The present segment, all of which is on the disk.
  WrittenSegment give_up_present(std::uint64_t bytes) {
    return {.file = std::exchange(file, File()),
            .index = {.segment = segment, .bytes = bytes, .epoch = holds.epoch}};
  }

  std::filesystem::path path(int number) const { return segment_path(options.folder, number); }

  bool is_at_its_place() const {
    return folder.is_at(options.folder) && (!file.is_open() || file.is_at(path(segment)));
  }

  // A segment that is on the disk with its first events, under a name that no reader takes.
  File prepare_next(const std::filesystem::path& unnamed) {
    remove_file(unnamed, disk);
    File next = File::create(unnamed, disk);
    segment_bytes = reserved_bytes = 0;
    buffer.clear();
    for (const Note& note : abandoned) put(kNoteChannel, encode(note));
    for (const auto& [channel, data] : preamble(holds)) put(channel, data);
    for (const auto& [channel, data] : clocks_going_on(holds)) put(channel, data);
    flush(next);
    next.sync();
    return next;
  }

  void open_next() {
    if (!is_at_its_place())
      throw std::system_error(ENODEV, std::generic_category(), "recording " + options.folder.string());
    if (file.is_open()) {
      put_last_commit(durable_bytes);
      sync();
    }
    (void)tidy();
    const std::uint64_t size_before = segment_bytes, reserved_before = reserved_bytes;
    const HeaderSum headers_before = std::exchange(headers, {});
    auto unnamed = path(segment + 1);
    unnamed += ".new";
    File next;
    try {
      next = prepare_next(unnamed);
      may_have_next = true;
      rename_file(unnamed, path(segment + 1), disk);
    } catch (...) {
      buffer.clear();  // the present segment is as it was, and can be gone on with
      segment_bytes = size_before;
      reserved_bytes = reserved_before;
      headers = headers_before;
      (void)disk.unlink(unnamed.c_str());
      throw;
    }
    if (file.is_open()) written = give_up_present(size_before);
    file = std::move(next);
    ++segment;
    may_have_next = false;
    durable_bytes = 0;
    if (!planted(PlantedFault::kNoFolderSync)) attempt([this] { folder.sync(); });
    all_is_durable();
    commit_due = false;
    abandoned.clear();
  }

  void remember(const NodeEpoch& key) {
    if (before.contains(key)) return;
    const auto known = holds.epoch.find(key);
    before.emplace(key, known == holds.epoch.end() ? std::nullopt : std::optional(known->second));
  }

  void append(std::string_view channel, std::span<const std::uint8_t> data, std::int64_t timestamp_us) {
    assert(!failed && "abandon() comes first");
    if (channel.empty() || channel.size() > kMaxLogChannelBytes || data.size() > kMaxLogDataBytes)
      throw std::invalid_argument("event on channel " + std::string(channel) + " with " +
                                  std::to_string(data.size()) + " bytes does not fit into a record");
    last_timestamp_us = timestamp_us;
    const std::uint64_t size = kLogHeaderBytes + channel.size() + data.size();
    const std::uint64_t commits = 2 * commit_event_bytes();  // one now and the last one
    if (!file.is_open() || segment_bytes + size + commits > options.segment_bytes) open_next();
    if (std::exchange(commit_due, false)) put_commit(durable_bytes);
    put(channel, data);
    if (buffer.size() >= kBufferBytes) attempt([this] { flush(file); });
    ++appended;
  }

  void append_other(std::string_view channel, std::span<const std::uint8_t> data, std::int64_t timestamp_us) {
    append(channel, data, timestamp_us);
    clocks_changed = clocks_changed || channel == kNoteChannel || channel.starts_with(kClockChannels);
    static_cast<void>(holds.clocks.take(channel, data));
  }

  void append(const SealedBlock& block, std::int64_t timestamp_us) {
    append(block_channel(block.header.node, block.kind), block.bytes(), timestamp_us);
    remember({block.header.node, block.header.epoch});
    add(block, holds);
  }
};

RecordWriter::RecordWriter(Options options, Disk& disk, RecordState before)
    : state_(std::make_unique<State>(std::move(options), disk)) {
  State& s = *state_;
  create_folders(s.options.folder, disk);
  if (!s.folder.take(s.options.folder, disk))
    throw std::runtime_error("recording " + s.options.folder.string() + ": another program writes to it");
  s.buffer.reserve(State::kBufferBytes + kMaxLogEventBytes);
  s.before_it = before;
  TakenOver found = take_over(s.folder.file(), std::move(before), disk);
  s.segment = found.segment;
  s.cut = std::move(found.cut);
  s.holds = std::move(found.holds);
  s.durable_clocks = s.holds.clocks;
}

RecordWriter::~RecordWriter() = default;
RecordWriter::RecordWriter(RecordWriter&&) noexcept = default;
RecordWriter& RecordWriter::operator=(RecordWriter&&) noexcept = default;

void RecordWriter::set_preamble(Preamble preamble) {
  state_->preamble = std::move(preamble);
}

void RecordWriter::append(std::string_view channel, std::span<const std::uint8_t> data,
                          std::int64_t timestamp_us) {
  SealedBlock block;
  if (channel.starts_with(kBlockChannels) && accept(data, block) == Refusal::kNone)
    append(block, timestamp_us);
  else
    state_->append_other(channel, data, timestamp_us);
}

void RecordWriter::append(const SealedBlock& block, std::int64_t timestamp_us) {
  for (const SealedBlock& given : state_->altered(block)) state_->append(given, timestamp_us);
}

void RecordWriter::sync() {
  if (state_->file.is_open()) state_->sync();
}

void RecordWriter::close() {
  State& s = *state_;
  if (!s.file.is_open()) return;
  s.put_last_commit(s.durable_bytes);
  s.sync();
  (void)s.tidy();
  s.attempt([&s] { s.give_up_present(s.segment_bytes).finish(s.options.folder, s.disk); });
}

bool RecordWriter::tidy() {
  return state_->tidy() || state_->cut_one();
}

void RecordWriter::abandon(const Note& stamp) {
  State& s = *state_;
  if (!s.failed) return;
  s.failed = false;
  s.buffer.clear();
  s.appended = s.durable;
  for (auto& [key, epoch] : std::exchange(s.before, {})) {
    if (epoch)
      s.holds.epoch[key] = *epoch;
    else
      s.holds.epoch.erase(key);
  }
  s.holds.clocks = s.durable_clocks;
  if (!s.file.is_open()) return;
  Note note = stamp;
  note.kind = NoteKind::kSegmentAbandoned;
  note.a = s.segment;
  note.b = static_cast<std::int64_t>(s.durable_bytes);
  s.abandoned.push_back(std::move(note));
  if (!cut_back(std::exchange(s.file, File()), s.durable_bytes, s.path(s.segment), s.disk))
    s.uncut[s.segment] = s.durable_bytes;
}

bool RecordWriter::is_at_its_place() const {
  return state_->is_at_its_place();
}

void RecordWriter::let_go(const Note& stamp) {
  state_->failed = true;
  abandon(stamp);
  state_->written.reset();
  state_->folder.let_go();
}

bool RecordWriter::is_away() const {
  return !state_->folder.is_taken();
}

bool RecordWriter::take_again() {
  State& s = *state_;
  RecordFolder folder;
  const auto busy = [&s] {
    throw std::system_error(EBUSY, std::generic_category(), "recording " + s.options.folder.string());
  };
  if (!folder.take(s.options.folder, s.disk)) busy();
  const auto numbers = segment_numbers(s.options.folder, s.disk);
  if (!holds_all_of(s.holds, s.options.folder, s.before_it, s.disk)) return false;
  if (!numbers.empty() && numbers.back() > s.segment + (s.may_have_next ? 1 : 0)) busy();
  if (!numbers.empty()) s.segment = std::max(s.segment, numbers.back());
  s.may_have_next = false;
  s.folder = std::move(folder);
  return true;
}

const std::optional<RecordWriter::CutTail>& RecordWriter::cut_tail() const {
  return state_->cut;
}
const RecordState& RecordWriter::holds() const {
  return state_->holds;
}
std::int64_t RecordWriter::appended() const {
  return state_->appended;
}
std::int64_t RecordWriter::durable() const {
  return state_->durable;
}
bool RecordWriter::has_failed() const {
  return state_->failed;
}
int RecordWriter::segment() const {
  return state_->segment;
}

}  // namespace roadbalance
