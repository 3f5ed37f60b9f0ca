#include <algorithm>
#include <charconv>
#include <cstdio>
#include <string>

#include "common/record/folder.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {

namespace {

std::string file_name(int number, std::string_view ending) {
  char name[32];
  std::snprintf(name, sizeof name, "seg-%06d", number);
  return name + std::string(ending);
}

}  // namespace

std::filesystem::path segment_path(const std::filesystem::path& folder, int number) {
  return folder / file_name(number, ".lcm");
}

std::optional<int> segment_of_file(std::string_view name, std::string_view ending) {
  constexpr std::string_view kBeginning = "seg-";
  int number = 0;
  if (!name.starts_with(kBeginning)) return std::nullopt;
  std::from_chars(name.data() + kBeginning.size(), name.data() + name.size(), number);
  return number > 0 && name == file_name(number, ending) ? std::optional(number) : std::nullopt;
}

std::vector<int> segment_numbers(const std::filesystem::path& folder, Disk& disk) {
  std::vector<int> numbers;
  for (const std::string& name : list_folder(folder, disk))
    if (const auto number = segment_of_file(name, ".lcm")) numbers.push_back(*number);
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace roadbalance
