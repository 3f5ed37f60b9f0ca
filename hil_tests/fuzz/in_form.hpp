#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "common/types/crc32c.hpp"

namespace roadbalance::fuzz {

inline constexpr std::size_t kFingerprintBytes = 8;
inline constexpr std::size_t kCrcBytes = 4;

/// The message `form` with the fuzzer's bytes for its fields: size, fingerprint and CRC are good, so that the
/// checks behind these are reached.  Where `bytes` ends, the form's own go on.
inline std::vector<std::uint8_t> in_form(std::vector<std::uint8_t> form,
                                         std::span<const std::uint8_t> bytes) {
  const std::size_t fields = form.size() - kFingerprintBytes - kCrcBytes;
  if (bytes.size() > kFingerprintBytes) {
    const auto given = bytes.subspan(kFingerprintBytes);
    std::copy_n(given.begin(), std::min(fields, given.size()), form.begin() + kFingerprintBytes);
  }
  std::uint32_t crc = crc32c(std::span(form).first(form.size() - kCrcBytes));
  for (std::size_t k = 0; k < kCrcBytes; ++k, crc <<= 8)
    form[form.size() - kCrcBytes + k] = static_cast<std::uint8_t>(crc >> 24);
  return form;
}

}  // namespace roadbalance::fuzz
