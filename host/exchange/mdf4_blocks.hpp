#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace roadbalance {

/// Blocks of an MDF4 file in memory, with links between them that may be set later.
///
/// A block: "##", two letters, 4 bytes 0, length, number of links (64 bits each, little endian), links, data;
/// it begins at a multiple of 8.  Source: ASAM MDF 4.1.0, section 4.
class Mdf4Blocks {
 public:
  using Position = std::uint64_t;

  /// Appends a block; links not yet known are 0.  @return its position in the file
  Position add(std::string_view id, std::vector<Position> links, std::span<const std::uint8_t> data);
  /// Text, ends with 0: ##TX, or XML: ##MD.
  Position add_text(std::string_view text) { return add_zero_ended("TX", text); }
  Position add_xml(std::string_view text) { return add_zero_ended("MD", text); }
  void set_link(Position block, std::size_t link, Position to);

  /// The identification, which is no block and begins a file; first of all.
  void identify(std::string_view program);

  Position end() const { return bytes_.size(); }
  std::span<const std::uint8_t> bytes() const { return bytes_; }

 private:
  Position add_zero_ended(std::string_view id, std::string_view text);

  std::vector<std::uint8_t> bytes_;
};

/// Fields of a block, little endian, in order.
class Mdf4Fields {
 public:
  template <typename Number>
  requires std::is_arithmetic_v<Number> Mdf4Fields& operator<<(Number number) {
    std::array<std::uint8_t, sizeof number> bytes;
    std::memcpy(bytes.data(), &number, sizeof number);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  Mdf4Fields& zeros(std::size_t count) {
    bytes_.insert(bytes_.end(), count, 0);
    return *this;
  }
  Mdf4Fields& text(std::string_view text) {
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    return *this;
  }
  std::span<const std::uint8_t> bytes() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

}  // namespace roadbalance
