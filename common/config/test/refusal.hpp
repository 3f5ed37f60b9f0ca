#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "common/config/section.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance::test {

/// Why this vehicle.toml is refused.
inline std::string refusal(const std::string& text) {
  try {
    VehicleConfig::parse(text, "car.toml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

/// It is refused with these words, and points to the line on which `words` end.
/// @param from  where the search for `words` begins
inline void expect_refusal(const std::string& text, std::size_t from, const std::string& words,
                           const std::string& says) {
  const auto place = text.find(words, from);
  ASSERT_NE(place, std::string::npos) << words;
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(place + words.size());
  const std::string where = "car.toml:" + std::to_string(1 + std::count(text.begin(), end, '\n')) + ": ";
  const std::string error = refusal(text);
  EXPECT_EQ(error.rfind(where, 0), 0U) << error << "\nshould point to: " << where << says;
  EXPECT_NE(error.find(says), std::string::npos) << error << "\nshould say: " << says;
}

}  // namespace roadbalance::test
