#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "host/analysis/identify/drive_sums.hpp"

namespace roadbalance {

/// The time of a node of which a recording holds scans of an epoch, which is the measured one, also in
/// a subset: from the first to the last of them, by the node's clock.
struct MeasuredTime {
  std::int32_t node;
  std::int64_t epoch, first_ns, last_ns;
};

/// One recording's contribution to an estimate from many, or why it has none.
struct DriveShare {
  std::optional<DriveSums> sums;
  std::string unusable;        ///< for people; empty: it is usable
  bool not_read = false;       ///< for it cannot be read at all
  std::string contradictions;  ///< what speaks against its zero marks
  std::int64_t missing_blocks = 0;
  std::vector<MeasuredTime> measured;  ///< of every node, in the order of their beginning
};

/// @throws Interrupted when asked to stop; nothing else: faults of a recording are in its share
DriveShare share_of(const std::filesystem::path& recording, bool refine, const std::stop_token& stop);

/// The same bit for bit in another process of this build.
std::vector<char> encode(const DriveShare& share);
/// Nothing if the bytes are none of encode().
std::optional<DriveShare> decode_drive_share(std::span<const char> bytes);

}  // namespace roadbalance
