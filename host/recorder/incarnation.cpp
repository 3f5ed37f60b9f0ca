#include "host/recorder/incarnation.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

#include "common/record/file.hpp"

namespace roadbalance {

namespace {

// One that is tried again and again, and never obeyed, must not fill the disk.
constexpr std::size_t kMostIncarnations = 1024;

// Nothing: it is no list of numbers.
std::optional<std::vector<std::int64_t>> numbers_in(std::string_view text) {
  std::vector<std::int64_t> numbers;
  while (!text.empty()) {
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || number < 1) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (!text.starts_with('\n')) return std::nullopt;
    text.remove_prefix(1);
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace

std::vector<std::int64_t> stored_incarnations(const std::filesystem::path& folder, Disk& disk) {
  const auto file = folder / kIncarnationFile;
  const auto text = read_whole_text(file, disk, Links::kRefused);
  if (!text) return {};
  auto numbers = numbers_in(*text);
  if (!numbers || numbers->empty())
    throw std::runtime_error(file.string() + ": not a positive number; remove it if no recorder runs");
  return *std::move(numbers);
}

std::int64_t stored_incarnation(const std::filesystem::path& folder, Disk& disk) {
  const auto numbers = stored_incarnations(folder, disk);
  return numbers.empty() ? 0 : numbers.back();
}

void keep_incarnation(const std::filesystem::path& folder, std::int64_t number, Disk& disk) {
  const auto before = read_whole_text(folder / kIncarnationFile, disk, Links::kRefused);
  std::vector<std::int64_t> numbers = numbers_in(before.value_or("")).value_or(std::vector<std::int64_t>{});
  if (std::ranges::find(numbers, number) == numbers.end()) numbers.push_back(number);
  std::ranges::sort(numbers);
  const std::size_t dropped = numbers.size() - std::min(numbers.size(), kMostIncarnations);
  std::string text;
  for (const std::int64_t one : std::span(numbers).subspan(dropped)) text += std::to_string(one) + "\n";
  write_atomically(folder / kIncarnationFile, text, disk);
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
