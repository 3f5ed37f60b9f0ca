#include "common/clock/utc.hpp"

#include <array>
#include <chrono>
#include <ctime>

namespace roadbalance {

std::int64_t utc_us() {
  using namespace std::chrono;
  return duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
}

std::string utc_text(std::int64_t utc_us, const char* pattern) {
  const std::time_t seconds = utc_us / 1'000'000;
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  std::array<char, 64> text{};
  return {text.data(), std::strftime(text.data(), text.size(), pattern, &utc)};
}

}  // namespace roadbalance
