#include <cerrno>
#include <system_error>
#include <utility>

#include "common/record/record.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {

struct RecordReader::State {
  std::filesystem::path folder;
  int number = 0;  // of the segment being read
  std::optional<SegmentReader> segment;
  std::vector<Damage> damage;
  bool finished = false;

  // Of the segment after the present one.  A writer creates it only when it has written all of the present
  // one.
  std::optional<int> following() const {
    for (const int candidate : segment_numbers(folder))
      if (candidate > number) return candidate;
    return std::nullopt;
  }
};

RecordReader::RecordReader(std::filesystem::path folder) : state_(std::make_unique<State>()) {
  state_->folder = std::move(folder);
  if (!std::filesystem::is_directory(state_->folder))
    throw std::system_error(ENOTDIR, std::generic_category(), "recording " + state_->folder.string());
  const auto first = state_->following();
  if (!first)
    throw std::system_error(ENOENT, std::generic_category(),
                            "recording " + state_->folder.string() + " holds no segment (seg-000001.lcm)");
  state_->number = *first;
  state_->segment.emplace(segment_path(state_->folder, *first));
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
    s.segment.emplace(segment_path(s.folder, *following));
  }
}

void RecordReader::finish() {
  state_->finished = true;
}

bool RecordReader::is_last(const std::filesystem::path& segment) const {
  return segment == segment_path(state_->folder, segment_numbers(state_->folder).back());
}

const std::vector<RecordReader::Damage>& RecordReader::damage() const {
  return state_->damage;
}

}  // namespace roadbalance
