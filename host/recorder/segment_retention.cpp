#include "host/recorder/segment_retention.hpp"

#include <system_error>
#include <utility>

#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "host/recording/manifest.hpp"

namespace roadbalance {

SegmentRetention::SegmentRetention(Disk& disk, std::int64_t keep_bytes, NoteDeletion note_deletion,
                                   std::vector<std::string>& warnings)
    : disk_(disk), keep_bytes_(keep_bytes), note_deletion_(std::move(note_deletion)), warnings_(warnings) {}

bool SegmentRetention::list(const std::filesystem::path& folder, int last) {
  if (last <= listed_) return false;
  try {
    write_manifest(folder, last, disk_);
    listed_ = last;
    if (keep_bytes_ > 0) choose(folder);
    return true;
  } catch (const std::system_error& error) {
    warnings_.push_back(error.what());
    return false;
  }
}

void SegmentRetention::choose(const std::filesystem::path& folder) {
  const auto sizes = read_manifest(folder, disk_);
  const auto size_of = [&](int number) { return sizes.find(segment_path({}, number).string()); };
  const std::vector<int> numbers = segment_numbers(folder, disk_);
  std::uint64_t total = 0;  // of what is there: that one that is listed is missing must cost no other
  for (const int number : numbers)
    if (const auto size = size_of(number); size != sizes.end()) total += size->second;
  for (const int number : numbers) {
    const auto size = size_of(number);
    if (total <= static_cast<std::uint64_t>(keep_bytes_) || number > listed_ || size == sizes.end()) return;
    total -= size->second;
    if (!to_delete_.insert(number).second) continue;
    notes_are_durable_ = false;
    note_deletion_(number, static_cast<std::int64_t>(size->second));
  }
}

// The manifest goes first, so that it lists nothing that is gone.
bool SegmentRetention::delete_one(const std::filesystem::path& folder) {
  if (to_delete_.empty() || !notes_are_durable_) return false;
  const int number = *to_delete_.begin();
  try {
    if (read_manifest(folder, disk_).contains(segment_path(folder, number).filename().string()))
      write_manifest(folder, listed_, disk_, to_delete_);
    delete_segment(folder, number, disk_);
    to_delete_.erase(number);
    ++deleted_;
    return true;
  } catch (const std::system_error& error) {
    warnings_.push_back(error.what());  // again after the next commit
    return false;
  }
}

void SegmentRetention::begin_anew() {
  listed_ = 0;
  to_delete_.clear();
}

}  // namespace roadbalance
