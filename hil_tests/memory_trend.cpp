#include "hil_tests/memory_trend.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace roadbalance::test {

std::optional<std::int64_t> own_memory_bytes(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string word; status >> word; status.ignore(std::numeric_limits<std::streamsize>::max(), '\n')) {
    std::int64_t kibibytes = 0;
    if (word == "RssAnon:" && status >> kibibytes) return 1024 * kibibytes;
  }
  return std::nullopt;
}

void MemoryTrend::add(double time_s, std::int64_t bytes) {
  if (time_s < settled_after_s_) return;
  if (!settled_) settled_ = most_ = bytes;
  most_ = std::max(most_, bytes);
}

}  // namespace roadbalance::test
