#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/types/crc32c.hpp"

/// The common form of all our messages on the wire: constant encoded size, fingerprint in front, big endian,
/// and in most of them a CRC-32C as the last four bytes.  For use inside common/bus only.
namespace roadbalance::wire_format {

inline constexpr std::size_t kCrcBytes = 4;

inline std::uint32_t load_u32(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 | std::uint32_t{bytes[2]} << 8 |
         bytes[3];
}

inline std::int64_t load_i64(const std::uint8_t* bytes) {
  return static_cast<std::int64_t>(std::uint64_t{load_u32(bytes)} << 32 | load_u32(bytes + 4));
}

inline void store_u32(std::uint32_t value, std::uint8_t* bytes) {
  bytes[0] = static_cast<std::uint8_t>(value >> 24);
  bytes[1] = static_cast<std::uint8_t>(value >> 16);
  bytes[2] = static_cast<std::uint8_t>(value >> 8);
  bytes[3] = static_cast<std::uint8_t>(value);
}

/// Encoded size of a message of generated type T: all extents are fixed, so it is the same for every value.
template <typename T>
std::size_t size_of() {
  static const auto size = static_cast<std::size_t>(T().getEncodedSize());
  return size;
}

template <typename T>
std::vector<std::uint8_t> encode(const T& message) {
  std::vector<std::uint8_t> bytes(size_of<T>());
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// Replaces the last four bytes by the CRC of those before.
inline void write_crc(std::span<std::uint8_t> bytes) {
  store_u32(crc32c(bytes.first(bytes.size() - kCrcBytes)), bytes.data() + bytes.size() - kCrcBytes);
}

template <typename T>
std::vector<std::uint8_t> encode_with_crc(const T& message) {
  auto bytes = encode(message);
  write_crc(bytes);
  return bytes;
}

/// Refuses every size but the one of T, checked before the generated decoder sees the bytes, and every other
/// fingerprint.
template <typename T>
std::optional<T> decode(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != size_of<T>()) return std::nullopt;
  T message;
  if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) != static_cast<int>(bytes.size()))
    return std::nullopt;
  return message;
}

template <typename T>
std::optional<T> decode_with_crc(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != size_of<T>() || !ends_with_its_crc(bytes)) return std::nullopt;
  return decode<T>(bytes);
}

}  // namespace roadbalance::wire_format
