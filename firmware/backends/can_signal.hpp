#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace roadbalance {

/// One classic CAN frame as it was received.
struct CanFrame {
  std::int64_t time_ns = 0;  ///< receiver's stamp
  std::string interface;     ///< e.g. "can0"
  std::uint32_t id = 0;      ///< 11 bits, or 29 if `extended`
  bool extended = false;
  std::size_t size = 0;  ///< bytes of `data` that count, 0 .. 8
  std::array<std::uint8_t, 8> data{};
};

/// One line of the log format of candump -L: "(seconds.microseconds) interface ID#DATA".
/// @return nothing if the line is anything else, e.g. a remote or CAN FD frame
std::optional<CanFrame> parse_candump(std::string_view line);

enum class ByteOrder {
  kBigEndian,     ///< "Motorola": bits go from the start bit down and on at bit 7 of the next byte
  kLittleEndian,  ///< "Intel": bits go from the start bit up and on at bit 0 of the next byte
};

/// Where a number lies in a frame and what it means; as a signal of a DBC file.
///
/// Bit 8 i + j is bit j of byte i, j = 0 the lowest.  The start bit is the most significant bit of a
/// big-endian signal and the least significant of a little-endian one.
struct CanSignal {
  ByteOrder order = ByteOrder::kBigEndian;
  int start_bit = 7;  ///< 0 .. 63
  int length = 8;     ///< bits, 1 .. 64
  bool is_signed = false;
  double scale = 1.0;
  double offset = 0.0;

  /// raw * scale + offset, or nothing if the frame is too short for the signal.
  std::optional<double> value(const CanFrame& frame) const;
};

}  // namespace roadbalance
