#pragma once

#include <cstdint>
#include <string>

namespace roadbalance {

/// The computer's idea of the time, microseconds since 1970.  For people and names: it may jump.
std::int64_t utc_us();

/// @param pattern  of strftime
std::string utc_text(std::int64_t utc_us, const char* pattern = "%Y-%m-%dT%H:%M:%SZ");

}  // namespace roadbalance
