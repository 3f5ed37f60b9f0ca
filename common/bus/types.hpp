#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace roadbalance {

/// A message type that occurs in a record: LCM's name and fingerprint, its constant encoded size, and its
/// .lcm file, from which the other three and every field follow.
struct RecordedType {
  std::string name;
  std::int64_t fingerprint;
  std::size_t bytes;
  std::string_view text;
};
/// The messages that nodes seal.
std::vector<RecordedType> block_types();
/// These and what the recorder adds.
std::vector<RecordedType> recorded_types();

/// Whether these bytes, whole (they end with their CRC), are what only a newer release reads: a message of
/// none of these types, or a note of another kind.
bool is_of_newer_release(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
