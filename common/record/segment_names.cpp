#include <algorithm>
#include <charconv>
#include <cstdio>

#include "common/record/folder.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {

std::filesystem::path segment_path(const std::filesystem::path& folder, int number) {
  char name[32];
  std::snprintf(name, sizeof name, "seg-%06d.lcm", number);
  return folder / name;
}

std::vector<int> segment_numbers(const std::filesystem::path& folder, Disk& disk) {
  std::vector<int> numbers;
  for (const std::string& name : list_folder(folder, disk)) {
    int number = 0;
    if (!name.starts_with("seg-") || !name.ends_with(".lcm")) continue;
    std::from_chars(name.data() + 4, name.data() + name.size() - 4, number);
    if (number > 0 && segment_path(folder, number).filename() == name) numbers.push_back(number);
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace roadbalance
