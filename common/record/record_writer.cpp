#include <algorithm>
#include <map>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/codec.hpp"
#include "common/record/folder.hpp"
#include "common/record/record.hpp"
#include "common/record/record_writer_state.hpp"
#include "common/record/segment.hpp"
#include "common/record/take_over.hpp"

namespace roadbalance {

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
  return state_->tidy();
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
  cut_back(std::exchange(s.file, File()), s.durable_bytes, s.path(s.segment), s.disk);
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
