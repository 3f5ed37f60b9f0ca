#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace roadbalance {

/// A message type that occurs in a record: LCM's name and fingerprint, and its constant encoded size.
struct BlockType {
  std::string name;
  std::int64_t fingerprint;
  std::size_t bytes;
};
std::vector<BlockType> block_types();

}  // namespace roadbalance
