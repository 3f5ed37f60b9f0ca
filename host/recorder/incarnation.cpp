#include "host/recorder/incarnation.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <stdexcept>
#include <string>
#include <system_error>

#include "common/record/file.hpp"

namespace roadbalance {

std::int64_t stored_incarnation(const std::filesystem::path& folder, Disk& disk) {
  const auto file = folder / kIncarnationFile;
  const auto text = read_whole_text(file, disk);
  if (!text) return 0;
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), number);
  if (error != std::errc() || number < 1 || std::string_view(end) != "\n")
    throw std::runtime_error(file.string() + ": not a positive number; remove it if no recorder runs");
  return number;
}

void keep_incarnation(const std::filesystem::path& folder, std::int64_t number, Disk& disk) {
  write_atomically(folder / kIncarnationFile, std::to_string(number) + "\n", disk);
}

std::int64_t next_incarnation(const std::filesystem::path& folder, std::int64_t least, Disk& disk) {
  const std::int64_t number = std::max(stored_incarnation(folder, disk) + 1, least);
  keep_incarnation(folder, number, disk);
  return number;
}

std::int64_t raise_incarnation(const std::filesystem::path& folder, std::int64_t obeyed, Disk& disk) {
  const std::int64_t stored = stored_incarnation(folder, disk);
  if (stored == 0)
    throw std::system_error(ENOENT, std::generic_category(), "open " + (folder / kIncarnationFile).string());
  const std::int64_t number = std::max(stored, obeyed) + 1;
  keep_incarnation(folder, number, disk);
  return number;
}

}  // namespace roadbalance
