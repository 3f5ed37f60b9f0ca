#include "host/recorder/verify_missing.hpp"

#include <algorithm>

#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "common/record/segment_extent.hpp"

namespace roadbalance {
namespace {

using FinishedSegments = std::map<std::string, std::uint64_t>;

void add(MissingSegments& found, const std::string& file, const std::string& what) {
  ++found.missing;
  found.lines.push_back(file + ": " + what);
}

void compare_with_manifest(const std::filesystem::path& folder, const FinishedSegments& finished,
                           int deleted_through, Disk& disk, MissingSegments& found) {
  for (const auto& [file, bytes] : finished) {
    const auto path = folder / file;
    if (!path_exists(path, disk)) {
      if (file > segment_path({}, deleted_through).string())
        add(found, file, "is missing; manifest.json lists it as finished");
    } else if (const auto size = size_of_file(path, disk); size < bytes) {
      add(found, file,
          "has " + std::to_string(size) + " of the " + std::to_string(bytes) + " bytes it was finished with");
    }
  }
}

}  // namespace

MissingSegments find_missing_segments(const std::filesystem::path& folder, const FinishedSegments& finished,
                                      int deleted_through, Disk& disk) {
  MissingSegments found;
  compare_with_manifest(folder, finished, deleted_through, disk, found);
  const std::vector<int> numbers = segment_numbers(folder, disk);
  int before = deleted_through;
  for (const int number : numbers) {
    const auto path = segment_path(folder, number);
    const std::string file = path.filename().string();
    if (number > before + 1)
      add(found, file,
          before == 0 ? "is the first one here" : "does not follow " + segment_path({}, before).string());
    before = std::max(before, number);
    if (size_of_file(path, disk) > 0 || finished.contains(file)) continue;
    if (number == numbers.back())
      found.lines.push_back(file + ": is empty: its recorder was killed when it began it");
    else if (!abandoned_before(segment_path(folder, number + 1), disk).contains(number))
      add(found, file, "is empty");
  }
  return found;
}

}  // namespace roadbalance
