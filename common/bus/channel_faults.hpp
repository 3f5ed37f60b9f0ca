#pragma once

#include <cstddef>

#include "common/bus/results.hpp"

namespace roadbalance {

/// Level::dead has two bits of each channel: it carries no signal, and its mean is where none can be.
inline bool is_dead(const Level& level, std::size_t channel) {
  return (level.dead >> channel & 1U) != 0;
}
inline bool is_railed(const Level& level, std::size_t channel) {
  return (level.dead >> (kChannels + channel) & 1U) != 0;
}
/// At a value beyond which it is cut off, whatever range vehicle.toml gives it.
inline bool is_clipped(const Level& level, std::size_t channel) {
  return (level.clipped >> channel & 1U) != 0;
}
inline void set_dead(Level& level, std::size_t channel) {
  level.dead |= 1U << channel;
}
inline void set_railed(Level& level, std::size_t channel) {
  level.dead |= 1U << (kChannels + channel);
}

}  // namespace roadbalance
