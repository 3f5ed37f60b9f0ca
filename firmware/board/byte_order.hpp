#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

namespace roadbalance::board {

/// Writes numbers one behind the other, least significant byte first.  The caller gives room for all of them.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::uint8_t> bytes) : bytes_(bytes) {}

  template <std::integral Number>
  void put(Number value) {
    put_low(static_cast<std::uint64_t>(value), sizeof(Number));
  }

  /// The low `width` bytes of a value.
  void put_low(std::uint64_t value, std::size_t width) {
    for (std::size_t k = 0; k < width; ++k) bytes_[at_++] = static_cast<std::uint8_t>(value >> (8 * k));
  }

  std::size_t written() const { return at_; }

 private:
  std::span<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

/// Reads what ByteWriter wrote.  The caller has checked the length.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <std::integral Number>
  Number take() {
    return static_cast<Number>(take_low(sizeof(Number)));
  }

  std::uint64_t take_low(std::size_t width) {
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < width; ++k) value |= std::uint64_t{bytes_[at_++]} << (8 * k);
    return value;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

}  // namespace roadbalance::board
