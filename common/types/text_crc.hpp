#pragma once

#include <cstdint>
#include <string_view>

#include "common/types/crc32c.hpp"

namespace roadbalance {

/// CRC-32C of a text's bytes: by it nodes and recorder recognise a vehicle.toml.
/// @param before  as of crc32c() of bytes
inline std::uint32_t crc32c(std::string_view text, std::uint32_t before = 0) {
  return crc32c({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, before);
}

}  // namespace roadbalance
