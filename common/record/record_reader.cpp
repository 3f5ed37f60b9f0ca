#include <cerrno>
#include <system_error>
#include <utility>

#include "common/record/folder.hpp"
#include "common/record/record.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {

struct RecordReader::State {
  State(std::filesystem::path where, Disk& on) : folder(std::move(where)), disk(on) {}

  std::filesystem::path folder;
  Disk& disk;
  int number = 0;  // of the segment being read
  std::optional<SegmentReader> segment;
  std::vector<Damage> damage;
  bool finished = false;

  // Of the segment after the present one.  A writer creates it only when it has written all of the present
  // one.
  std::optional<int> following() const {
    for (const int candidate : segment_numbers(folder, disk))
      if (candidate > number) return candidate;
    return std::nullopt;
  }
};

RecordReader::RecordReader(std::filesystem::path folder, Disk& disk)
    : state_(std::make_unique<State>(std::move(folder), disk)) {
  State& s = *state_;
  if (!is_folder(s.folder, disk))
    throw std::system_error(ENOTDIR, std::generic_category(), "recording " + s.folder.string());
  const auto first = s.following();
  if (!first)
    throw std::system_error(ENOENT, std::generic_category(),
                            "recording " + s.folder.string() + " holds no segment (seg-000001.lcm)");
  s.number = *first;
  s.segment.emplace(segment_path(s.folder, *first), disk);
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
    if (auto event = s.segment->next(true, s.damage)) return event;
    if (!following) return std::nullopt;
    s.number = *following;
    s.segment.emplace(segment_path(s.folder, *following), s.disk);
  }
}

void RecordReader::finish() {
  state_->finished = true;
}

bool RecordReader::is_last(const std::filesystem::path& segment) const {
  return segment == segment_path(state_->folder, segment_numbers(state_->folder, state_->disk).back());
}

const std::vector<RecordReader::Damage>& RecordReader::damage() const {
  return state_->damage;
}

}  // namespace roadbalance
