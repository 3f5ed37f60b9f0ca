#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/types/exchange.hpp"

namespace roadbalance {

/// The time line's messages; fields as in common/wire.  Decoding refuses wrong size, type, CRC or bounds.

std::vector<std::uint8_t> encode(const ClockExchange& exchange);
std::vector<std::uint8_t> encode(const ClockFit& fit);
std::optional<ClockExchange> decode_clock_exchange(std::span<const std::uint8_t> bytes);
std::optional<ClockFit> decode_clock_fit(std::span<const std::uint8_t> bytes);

/// The beginning of the channels of exchanges and fits.
inline constexpr const char* kClockChannels = "RB_CLOCK_";
/// RB_CLOCK_EXCHANGE_<node>, in the record only, and RB_CLOCK_<node>.
std::string clock_exchange_channel(int node);
std::string clock_fit_channel(int node);

}  // namespace roadbalance
