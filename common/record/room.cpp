#include "common/record/room.hpp"

#include <stdexcept>

#include "common/text/format.hpp"

namespace roadbalance {

std::string bytes_text(std::uint64_t bytes) {
  constexpr std::uint64_t kGigabyte = 1'000'000'000;
  const double number = static_cast<double>(bytes);
  return bytes < kGigabyte ? format("%.1f MB", 1e-6 * number) : format("%.1f GB", 1e-9 * number);
}

void expect_room(const std::filesystem::path& folder, std::uint64_t least, Disk& disk) {
  const std::int64_t free = disk.free_bytes(folder.c_str());
  if (free < 0 || static_cast<std::uint64_t>(free) >= least) return;
  throw std::runtime_error(folder.string() + ": at least " + bytes_text(least) + " are to go there, " +
                           bytes_text(static_cast<std::uint64_t>(free)) +
                           " are free: make room on its disk, and begin again");
}

}  // namespace roadbalance
