#include "host/recorder/incarnation.hpp"

#include <algorithm>
#include <charconv>
#include <stdexcept>
#include <string>

#include "common/record/file.hpp"

namespace roadbalance {
namespace {

std::int64_t store(const std::filesystem::path& folder, std::int64_t number, Disk& disk) {
  write_atomically(folder / kIncarnationFile, std::to_string(number) + "\n", disk);
  return number;
}

}  // namespace

std::int64_t stored_incarnation(const std::filesystem::path& folder, Disk& disk) {
  const auto file = folder / kIncarnationFile;
  const auto text = read_text(file, disk);
  if (!text) return 0;
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), number);
  if (error != std::errc() || number < 1 || std::string_view(end) != "\n")
    throw std::runtime_error(file.string() + ": not a positive number; remove it if no recorder runs");
  return number;
}

std::int64_t next_incarnation(const std::filesystem::path& folder, std::int64_t utc_ms, Disk& disk) {
  return store(folder, std::max(stored_incarnation(folder, disk) + 1, utc_ms), disk);
}

std::int64_t raise_incarnation(const std::filesystem::path& folder, std::int64_t obeyed, Disk& disk) {
  return store(folder, std::max(stored_incarnation(folder, disk), obeyed) + 1, disk);
}

}  // namespace roadbalance
