#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "common/types/crc32c.hpp"

namespace roadbalance::test {

/// The same bytes as a release would send them whose message type has another fingerprint, with a good CRC.
/// @param version  one or more: each is another
inline std::vector<std::uint8_t> of_another_version(std::vector<std::uint8_t> bytes,
                                                    std::uint8_t version = 1) {
  bytes[7] ^= version;  // the fingerprint's last byte
  const std::size_t end = bytes.size() - 4;
  const std::uint32_t crc = crc32c({bytes.data(), end});
  for (std::size_t k = 0; k < 4; ++k) bytes[end + k] = static_cast<std::uint8_t>(crc >> (24 - 8 * k));
  return bytes;
}

/// As sentences give it.
inline std::string fingerprint_text(const std::vector<std::uint8_t>& bytes) {
  std::string text;
  for (std::size_t k = 0; k < 8; ++k) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", bytes[k]);
    text += digits;
  }
  return text;
}

}  // namespace roadbalance::test
