#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/types/scan.hpp"

namespace roadbalance {

inline constexpr const char* kTapChannel = "RB_KNOCK";

/// A tap on the car at rest, as one node's channels felt it; fields as in common/wire/knock_t.
struct Tap {
  std::int32_t node = 0;
  std::int64_t time_ns = 0;
  std::int64_t number = 0;
  std::int32_t channel = 0;  ///< 0 .. kAccelerations - 1
  std::array<double, kAccelerations> first_m_s2{}, peak_m_s2{};
};

std::vector<std::uint8_t> encode(const Tap& tap);
std::optional<Tap> decode_tap(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
