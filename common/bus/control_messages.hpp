#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/types/control.hpp"

namespace roadbalance {

/// Encoded with CRC where the message has one; decoding refuses wrong size, type, CRC or bounds.
std::vector<std::uint8_t> encode(const Heartbeat& message);
std::vector<std::uint8_t> encode(const Ack& message);
std::vector<std::uint8_t> encode(const Command& message);
std::vector<std::uint8_t> encode(const Reply& message);
std::vector<std::uint8_t> encode(const VehiclePart& message);
std::optional<Heartbeat> decode_heartbeat(std::span<const std::uint8_t> bytes);
std::optional<Ack> decode_ack(std::span<const std::uint8_t> bytes);
std::optional<Command> decode_command(std::span<const std::uint8_t> bytes);
std::optional<Reply> decode_reply(std::span<const std::uint8_t> bytes);
std::optional<VehiclePart> decode_vehicle_part(std::span<const std::uint8_t> bytes);

}  // namespace roadbalance
