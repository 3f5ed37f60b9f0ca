#include "host/recorder/incarnation.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <stdexcept>
#include <string>

#include "common/record/file.hpp"

namespace roadbalance {
namespace {

std::int64_t stored(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return 0;
  std::int64_t number = 0;
  if (!(std::ifstream(file) >> number) || number < 1)
    throw std::runtime_error(file.string() + ": not a positive number; remove it if no recorder runs");
  return number;
}

std::int64_t store(const std::filesystem::path& file, std::int64_t number) {
  write_atomically(file, std::to_string(number) + "\n");
  return number;
}

}  // namespace

std::int64_t next_incarnation(const std::filesystem::path& folder) {
  using namespace std::chrono;
  const auto file = folder / "incarnation";
  const std::int64_t now_ms = duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
  return store(file, std::max(stored(file) + 1, now_ms));
}

std::int64_t raise_incarnation(const std::filesystem::path& folder, std::int64_t obeyed) {
  const auto file = folder / "incarnation";
  return store(file, std::max(stored(file), obeyed) + 1);
}

}  // namespace roadbalance
