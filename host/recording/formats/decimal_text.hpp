#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>

namespace roadbalance {

/// Decimals that a value needs so that it distinguishes counts of `scale`: one more than they have.
inline int decimals_of(double scale) {
  return static_cast<int>(std::clamp(std::ceil(-std::log10(std::abs(scale))) + 1.0, 0.0, 15.0));
}

inline constexpr std::size_t kDecimalText = 32;  ///< characters that one number takes at most

/// Writes `scaled` / 10^decimals with a decimal point; returns the end.
/// @param to  with room for kDecimalText
inline char* write_decimal(char* to, std::int64_t scaled, int decimals) {
  std::uint64_t magnitude = static_cast<std::uint64_t>(scaled);
  if (scaled < 0) {
    *to++ = '-';
    magnitude = ~magnitude + 1;
  }
  char digits[20];
  const auto count = std::to_chars(digits, digits + sizeof digits, magnitude).ptr - digits;
  const std::ptrdiff_t whole = std::max<std::ptrdiff_t>(count - decimals, 0);
  if (whole == 0) *to++ = '0';
  to = std::copy_n(digits, whole, to);
  if (decimals == 0) return to;
  *to++ = '.';
  to = std::fill_n(to, decimals - (count - whole), '0');
  return std::copy(digits + whole, digits + count, to);
}

/// Writes a value with so many decimals, or as many digits as it has if those are more than 15.
inline char* write_decimal(char* to, double value, double power, int decimals) {
  const double scaled = value * power;
  if (!(std::abs(scaled) < 1e15)) return std::to_chars(to, to + kDecimalText, value).ptr;
  return write_decimal(to, static_cast<std::int64_t>(std::llround(scaled)), decimals);
}

}  // namespace roadbalance
