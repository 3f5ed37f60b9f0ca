#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/dbc/can_frame.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {

/// The contents of frames of a CAN accelerometer module; the layout is in ACCELEROMETER.md.
struct AccelerometerFrame {
  static constexpr std::uint8_t kVersion = 1;
  static constexpr int kParts = 4;  ///< frames of a conversion in classic CAN
  static constexpr int kChannelsOfPart = kAccelerations / kParts;
  static constexpr std::size_t kFdBytes = 32;

  std::uint32_t sequence = 0;                         ///< of a part: its low 8 bits
  std::optional<int> part;                            ///< of classic CAN, 0 .. 3; nothing: all channels
  std::uint16_t overload = 0;                         ///< bit k: channel k of the twelve
  std::array<std::int16_t, kAccelerations> sample{};  ///< of a part: its three, at their places
};

/// Nothing if it is no frame of the module with this first identifier, or not of this version.
std::optional<AccelerometerFrame> read_accelerometer(const CanFrame& frame, std::uint32_t first_id) noexcept;

/// The frame of a module with this first identifier.
CanFrame write_accelerometer(const AccelerometerFrame& content, std::uint32_t first_id);

}  // namespace roadbalance
