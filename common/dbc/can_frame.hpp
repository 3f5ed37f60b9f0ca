#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace roadbalance {

inline constexpr std::size_t kClassicCanBytes = 8;
inline constexpr std::size_t kLongestCanBytes = 64;  ///< of a CAN FD frame
inline constexpr std::uint32_t kHighestStandardId = 0x7FF;
inline constexpr std::uint32_t kHighestExtendedId = 0x1FFF'FFFF;

/// One data frame, classic or CAN FD.
struct CanFrame {
  std::uint32_t id = 0;  ///< 11 bits, or 29 if `extended`
  bool extended = false;
  bool is_fd = false;     ///< sent in CAN FD format
  std::uint8_t size = 0;  ///< bytes of `data` that count
  std::array<std::uint8_t, kLongestCanBytes> data{};
};

/// The data lengths there are: 0 .. 8, in CAN FD also 12, 16, 20, 24, 32, 48, 64 (ISO 11898-1).
constexpr bool is_can_size(std::size_t size, bool is_fd) {
  if (size <= kClassicCanBytes) return true;
  return is_fd && (size <= 24 ? size % 4 == 0 : size == 32 || size == 48 || size == 64);
}

}  // namespace roadbalance
