#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/link/block.hpp"
#include "common/record/record_state.hpp"

namespace roadbalance {

inline constexpr const char* kRecordFormat = "roadbalance record";
inline constexpr int kRecordFormatVersion = 1;

using RecordEvents = std::vector<std::pair<std::string, std::vector<std::uint8_t>>>;

/// What every segment begins with, so that it can be read without the others: a JSON text of the format's
/// version and the names and fingerprints of the block types (from node 0, the host), and these
/// vehicle.toml: of the epochs that go on (see going_on()).  All have sequence 0: they repeat, and are no
/// part of any node's sequence.
RecordEvents make_preamble(const RecordState& holds);
RecordEvents make_preamble(const std::map<NodeEpoch, std::vector<SealedBlock>>& vehicle);

}  // namespace roadbalance
