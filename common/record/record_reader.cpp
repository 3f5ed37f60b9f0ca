#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "common/record/folder.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"

namespace roadbalance {

struct RecordReader::State {
  State(std::filesystem::path where, Disk& on) : folder(std::move(where)), disk(on) {}

  std::filesystem::path folder;
  Disk& disk;
  int number = 0;  // of the segment being read
  std::optional<SegmentReader> segment;
  std::vector<Damage> damage;
  bool finished = false;
  std::optional<int> last;   // the last segment with an event, once the record is finished
  std::vector<Damage> torn;  // of it and those behind it

  // The segment after the present one.  A writer creates it only when it has written all of the present one.
  std::optional<int> following() const {
    if (last && number >= *last) return std::nullopt;
    for (const int candidate : segment_numbers(folder, disk))
      if (candidate > number) return candidate;
    return std::nullopt;
  }

  // Segment `next`, or, if the retention mode takes it away meanwhile, the first behind it.  False if there
  // is none.
  bool open(int next) {
    while (!try_open(next)) {
      number = next;
      const auto behind = following();
      if (!behind) return false;
      next = *behind;
    }
    number = next;
    honour_abandonment();
    if (finished) find_end();
    return true;
  }

  bool try_open(int next) {
    const auto path = segment_path(folder, next);
    try {
      SegmentReader opened(path, disk);
      segment = std::move(opened);
      return true;
    } catch (const std::system_error& error) {
      if (error.code() != std::errc::no_such_file_or_directory) throw;
      return false;
    }
  }

  // A segment behind this one may hold where this one ends; one without any event does not.
  void honour_abandonment() {
    for (const int later : segment_numbers(folder, disk)) {
      if (later <= number) continue;
      const auto path = segment_path(folder, later);
      // It may have gone since it was listed; then the present one has gone too.
      if (!path_exists(path, disk) || size_of_file(path, disk) == 0) continue;
      const auto ends = abandoned_before(path, disk);
      if (const auto end = ends.find(number); end != ends.end())
        segment->end_at(std::max(end->second, segment->end_of_events()));
      return;
    }
  }

  // Where the last segment was torn it ends, and segments without any event behind it never began.
  void find_end() {
    if (last) {
      if (number == *last) limit_last();
      return;
    }
    const RecordEnd end = end_of_record(folder, number, disk);
    last = end.last;
    for (const auto& [at, extent] : end.unfinished) {
      // A segment gets its name when its first events are on the disk: garbage alone is nothing that was
      // torn.
      const bool is_torn = extent.end > 0;
      if (extent.end < extent.size)
        torn.insert(torn.begin(), {.segment = segment_path(folder, at),
                                   .offset = extent.end,
                                   .bytes = extent.size - extent.end,
                                   .what = is_torn ? "are a torn tail" : kIsNoEvent,
                                   .torn = is_torn});
    }
    if (number == *last) limit_last();
  }

  void limit_last() {
    if (!torn.empty() && torn.front().segment == segment->path())
      segment->end_at(std::max(torn.front().offset, segment->end_of_events()));
  }
};

RecordReader::RecordReader(std::filesystem::path folder, Disk& disk, int first)
    : state_(std::make_unique<State>(std::move(folder), disk)) {
  State& s = *state_;
  if (!is_folder(s.folder, disk))
    throw std::system_error(path_exists(s.folder, disk) ? ENOTDIR : ENOENT, std::generic_category(),
                            "recording " + s.folder.string());
  s.number = first - 1;
  const auto begin = s.following();
  if (!begin || !s.open(*begin))
    throw std::system_error(
        ENOENT, std::generic_category(),
        "recording " + s.folder.string() + " holds no segment (" + segment_path({}, first).string() + ")");
}

RecordReader::~RecordReader() = default;
RecordReader::RecordReader(RecordReader&&) noexcept = default;

std::optional<LogEvent> RecordReader::next() {
  State& s = *state_;
  for (;;) {
    if (auto event = s.segment->next(false, s.damage)) return event;
    const auto following = s.following();
    if (!following && !s.finished) return std::nullopt;
    // No more is written here: once more to the very end, then on.
    if (following && !s.finished) s.honour_abandonment();
    if (auto event = s.segment->next(true, s.damage)) return event;
    if (!following) {
      s.damage.insert(s.damage.end(), s.torn.begin(), s.torn.end());
      s.torn.clear();
      return std::nullopt;
    }
    if (!s.open(*following)) return std::nullopt;
  }
}

void RecordReader::finish() {
  state_->finished = true;
  state_->find_end();
}

int RecordReader::segment() const {
  return state_->number;
}

std::uint64_t RecordReader::offset() const {
  return state_->segment->offset();
}

const std::vector<RecordReader::Damage>& RecordReader::damage() const {
  return state_->damage;
}

}  // namespace roadbalance
