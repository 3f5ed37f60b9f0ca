#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/dbc/can_frame.hpp"

namespace roadbalance {

enum class ByteOrder {
  kBigEndian,     ///< "Motorola": bits go from the start bit down and on at bit 7 of the next byte
  kLittleEndian,  ///< "Intel": bits go from the start bit up and on at bit 0 of the next byte
};

/// A signal's value before scale and offset, from its bits.
enum class CanNumber { kUnsigned, kSigned, kFloat, kDouble };

/// Where a number lies in a frame and what it means; as a signal of a DBC file.
///
/// Bit 8 i + j is bit j of byte i, j = 0 the lowest.  The start bit is the most significant bit of a
/// big-endian signal and the least significant of a little-endian one.
struct CanSignal {
  ByteOrder order = ByteOrder::kBigEndian;
  int start_bit = 7;  ///< 0 .. 511
  int length = 8;     ///< bits, 1 .. 64; of a float 32, of a double 64
  CanNumber number = CanNumber::kUnsigned;
  double scale = 1.0;  ///< not 0
  double offset = 0.0;

  /// True if all bits lie in a frame of so many bytes.
  bool fits(std::size_t frame_bytes) const noexcept;

  /// The bits as they are, the most significant `length` - 1; nothing if the frame is too short.
  std::optional<std::uint64_t> bits(const CanFrame& frame) const noexcept;
  /// The number the bits stand for, before scale and offset.
  double raw(std::uint64_t bits) const noexcept;
  /// The value in the signal's unit.
  double value(double raw) const noexcept { return raw * scale + offset; }

  /// The inverse, for who plays a bus.  Writes the bits into a frame whose size is set; false, and the frame
  /// as it was, if it is too short.
  [[nodiscard]] bool put_bits(std::uint64_t bits, CanFrame& frame) const noexcept;
  /// Writes the nearest to `value`; false if the frame is too short or the bits cannot hold it.
  [[nodiscard]] bool put(double value, CanFrame& frame) const noexcept;
};

}  // namespace roadbalance
