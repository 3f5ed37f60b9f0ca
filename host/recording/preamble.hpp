#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/record/record_state.hpp"

namespace roadbalance {

inline constexpr const char* kRecordFormat = "roadbalance record";
/// 3: segments begin with the clocks; ends have the CRC of their epoch's blocks, journal entries all counters
/// of loss.  4: commits cover the contents of all events but nodes' blocks.
inline constexpr int kRecordFormatVersion = 4;

/// The begin of every segment, by which it can be read without the others and without this program: a JSON
/// text (from node 0, the host) with the versions of format and program, and name, fingerprint, size and .lcm
/// text of each message type; and the vehicle.toml of each epoch that goes on (see going_on()).  All have
/// sequence 0: they repeat, and are no part of any node's sequence.
RecordEvents make_preamble(const RecordState& holds);
RecordEvents make_preamble(const RecordState::Descriptions& vehicle);

/// The description that a recording contains.
struct RecordDescription {
  std::string program;  ///< that wrote it: name and version
  int format_version = 0;
  std::vector<std::string> types;  ///< whose texts are in it
};
/// The description in the first segment; nothing if it has no complete one.
/// @throws std::system_error naming the folder if it holds no segment
std::optional<RecordDescription> read_description(const std::filesystem::path& folder);

}  // namespace roadbalance
