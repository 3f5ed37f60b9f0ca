#pragma once

#include <cstddef>
#include <string_view>

namespace roadbalance {

// A message of LCM in one datagram: magic, number (big endian), name of the channel with a zero behind it,
// bytes.
inline constexpr std::string_view kMagicShort = "LC02";
inline constexpr std::size_t kShortHeader = 8;      ///< magic and number
inline constexpr std::size_t kLongestChannel = 63;  ///< LCM's own limit

}  // namespace roadbalance
