#include "host/recording/verify/verify_missing.hpp"

#include <algorithm>
#include <limits>

#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_extent.hpp"
#include "common/record/segment_index.hpp"

namespace roadbalance {
namespace {

void add(MissingSegments& found, const std::string& file, const std::string& what) {
  ++found.missing;
  found.lines.push_back(file + ": " + what);
}

/// Where abandoned segments end, by their number.  One that ends at byte 0 held nothing that was promised,
/// and a power cut may have taken its name, too.
std::map<int, std::uint64_t> ends_of_abandoned(const std::filesystem::path& folder,
                                               const std::vector<int>& numbers, Disk& disk) {
  std::map<int, std::uint64_t> ends;
  for (const int number : numbers) {
    const auto path = segment_path(folder, number);
    if (size_of_file(path, disk) > 0) ends.merge(abandoned_before(path, disk));
  }
  return ends;
}

void compare_with_manifest(const std::filesystem::path& folder, const FinishedSegments& finished,
                           const std::set<int>& deleted, const std::map<int, std::uint64_t>& abandoned,
                           Disk& disk, MissingSegments& found) {
  for (const auto& [file, listed] : finished) {
    const int number = segment_of_file(file, ".lcm").value_or(0);
    const auto given_up = abandoned.find(number);
    const std::uint64_t bytes = given_up == abandoned.end() ? listed : std::min(listed, given_up->second);
    const auto path = folder / file;
    if (!path_exists(path, disk)) {
      if (bytes > 0 && !deleted.contains(number))
        add(found, file, "is missing; manifest.json lists it as finished");
    } else if (const auto size = size_of_file(path, disk); size < bytes) {
      add(found, file,
          "has " + std::to_string(size) + " of the " + std::to_string(bytes) + " bytes it was finished with");
    } else if (size > bytes && given_up == abandoned.end()) {
      add(found, file,
          "has " + std::to_string(size) + " bytes; it was finished with " + std::to_string(bytes));
    }
  }
}

/// Segments that the manifest does not list, by their indexes.  The index of the segment deleted last stays.
void compare_with_indexes(const std::filesystem::path& folder, const FinishedSegments& finished,
                          int deleted_through, const std::map<int, std::uint64_t>& abandoned, Disk& disk,
                          MissingSegments& found) {
  auto names = list_folder(folder, disk);
  std::ranges::sort(names);
  for (const std::string& name : names) {
    const auto number = segment_of_file(name, ".idx");
    const std::string file = number ? segment_path({}, *number).string() : "";
    if (!number || *number <= deleted_through || finished.contains(file)) continue;
    const auto given_up = abandoned.find(*number);
    const std::uint64_t least =
        given_up == abandoned.end() ? std::numeric_limits<std::uint64_t>::max() : given_up->second;
    if (!path_exists(folder / file, disk)) {
      // Even a damaged index proves that there was a segment.
      if (least > 0) add(found, file, "is missing; its index is here");
      continue;
    }
    const auto index = read_index_alone(folder, *number, disk);
    const std::uint64_t bytes = index ? std::min(index->bytes, least) : 0;
    if (const auto size = size_of_file(folder / file, disk); size < bytes)
      add(found, file,
          "has " + std::to_string(size) + " of the " + std::to_string(bytes) + " bytes that its index says");
  }
}

std::vector<SegmentRun> runs_deleted(int through, const FinishedSegments& finished,
                                     const std::set<int>& deleted) {
  std::set<int> ends{through + 1};  // a run lies between two that are listed
  for (const auto& [file, bytes] : finished)
    if (const int number = segment_of_file(file, ".lcm").value_or(0);
        number >= 1 && number <= through && !deleted.contains(number))
      ends.insert(number);
  std::vector<SegmentRun> runs;
  int first = 1;
  for (const int end : ends) {
    if (first < end) runs.push_back({first, end - 1});
    first = end + 1;
  }
  return runs;
}

}  // namespace

std::string in_words(SegmentRun run) {
  if (run.first == run.last) return "segment " + std::to_string(run.first);
  return "segments " + std::to_string(run.first) + " to " + std::to_string(run.last);
}

MissingSegments find_missing_segments(const std::filesystem::path& folder, const FinishedSegments& finished,
                                      const std::set<int>& deleted, Disk& disk) {
  const int deleted_through = deleted.empty() ? 0 : *deleted.rbegin();
  MissingSegments found;
  const std::vector<int> numbers = segment_numbers(folder, disk);
  const auto abandoned = ends_of_abandoned(folder, numbers, disk);
  const auto never_began = [&](int number) {
    const auto end = abandoned.find(number);
    return end != abandoned.end() && end->second == 0;
  };
  compare_with_manifest(folder, finished, deleted, abandoned, disk, found);
  compare_with_indexes(folder, finished, deleted_through, abandoned, disk, found);
  const int first_here = numbers.empty() ? 1 : numbers.front();
  found.deleted = runs_deleted(std::min(first_here - 1, deleted_through), finished, deleted);
  int before = deleted_through;
  for (const int number : numbers) {
    const auto path = segment_path(folder, number);
    const std::string file = path.filename().string();
    while (before + 1 < number && never_began(before + 1)) ++before;
    if (number > before + 1)
      add(found, file,
          before == 0 ? "is the first one here" : "does not follow " + segment_path({}, before).string());
    before = std::max(before, number);
    if (size_of_file(path, disk) > 0 || finished.contains(file)) continue;
    if (number == numbers.back())
      found.lines.push_back(file + ": is empty: its recorder was killed when it began it");
    else if (!abandoned.contains(number))
      add(found, file, "is empty");
  }
  return found;
}

}  // namespace roadbalance
