#include "host/recording/recordings_given.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "common/config/section.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

bool is_recording(const fs::path& folder) {
  return fs::is_directory(folder) && !segment_numbers(folder).empty();
}

bool half_made(const fs::path& folder) {
  const std::string name = folder.filename().string();
  return name.starts_with('.') || name.ends_with(".part");
}

}  // namespace

std::vector<fs::path> recordings_given(std::span<const std::string> named) {
  std::vector<fs::path> all;
  std::set<fs::path> seen;
  const auto add = [&](const fs::path& recording) {
    if (!seen.insert(recording).second)
      throw ConfigError("recording " + recording.string() + " is named twice: a drive counts once");
    all.push_back(recording);
  };
  for (const std::string& name : named) {
    const fs::path folder = fs::canonical(name);
    const std::size_t before = all.size();
    bool folders = false;
    if (fs::is_directory(folder) && !is_recording(folder))
      for (const auto& entry : fs::directory_iterator(folder))
        if (!half_made(entry.path()) && is_recording(entry.path())) {
          folders = true;
          add(fs::canonical(entry.path()));
        }
    if (!folders && all.size() == before) add(folder);  // its fault is reported when it is read
  }
  std::sort(all.begin(), all.end(), [](const fs::path& a, const fs::path& b) {
    return std::pair(a.filename(), a) < std::pair(b.filename(), b);
  });
  return all;
}

std::uint64_t bytes_of_recording(const fs::path& recording) {
  std::error_code error;  // a read error is reported when it is read
  std::uint64_t sum = 0;
  for (const auto& entry : fs::directory_iterator(recording, error))
    if (const std::uint64_t bytes = entry.file_size(error); !error) sum += bytes;
  return sum;
}

}  // namespace roadbalance
