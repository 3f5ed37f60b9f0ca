#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace roadbalance {

/// A whole number of a file in JSON.  JSON's own conversion takes 4e52 for one, too, which no integer holds.
/// @throws std::out_of_range if it is none from `least` to `most`
inline std::int64_t whole_number(const nlohmann::json& json, std::int64_t least = INT64_MIN,
                                 std::int64_t most = INT64_MAX) {
  const bool is_too_large = json.is_number_unsigned() && json.get<std::uint64_t>() > INT64_MAX;
  if (json.is_number_integer() && !is_too_large)
    if (const auto number = json.get<std::int64_t>(); least <= number && number <= most) return number;
  throw std::out_of_range("no whole number from " + std::to_string(least) + " to " + std::to_string(most));
}

/// The same for an int32.
inline std::int32_t small_number(const nlohmann::json& json, std::int32_t least = 0,
                                 std::int32_t most = INT32_MAX) {
  return static_cast<std::int32_t>(whole_number(json, least, most));
}

}  // namespace roadbalance
