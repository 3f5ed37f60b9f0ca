#pragma once

#include <string>

#include "common/config/vehicle_config.hpp"
#include "firmware/board/protocol.hpp"

namespace roadbalance {

/// Each of two boards gives half of the node's channels, 1-6 and 7-12, from its first six inputs.  The first
/// board, the master, has the encoders and the references.
inline constexpr std::size_t kInputsOfPair = board::kInputChannels / 2;

/// The requests a board gets before it runs.
struct BoardSetup {
  board::Configuration configuration;
  board::ReferenceSetup references;
};

/// Whether this node can talk to a board: the empty text, or why not, naming both versions.
std::string protocol_refusal(const board::Identity& identity);
/// A sentence on something that works but that a person should know, e.g. a newer minor version; or the empty
/// text.
std::string protocol_note(const board::Identity& identity);

/// @param which   of the node's boards
/// @param boards  how many there are, 1 or 2
/// @throws ConfigError naming the key of vehicle.toml whose value the board does not have, and what it has
BoardSetup board_setup(const VehicleConfig& vehicle, const NodeConfig& node, const board::Identity& identity,
                       std::size_t which, std::size_t boards);

/// Amplitude of the references at the converter, of full scale: room for the filter's overshoot.
inline constexpr std::int32_t kReferencePerMille = 900;

}  // namespace roadbalance
