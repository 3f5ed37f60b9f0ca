#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace roadbalance::fuzz {

/// Turns a fuzzer's bytes into numbers, from the front; behind the end everything is 0.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool empty() const { return bytes_.empty(); }
  std::span<const std::uint8_t> take(std::size_t count) {
    const auto taken = bytes_.first(std::min(count, bytes_.size()));
    bytes_ = bytes_.subspan(taken.size());
    return taken;
  }
  /// Big endian, of `width` bytes at most 8.
  std::uint64_t number(std::size_t width) {
    std::uint64_t value = 0;
    for (const std::uint8_t byte : take(width)) value = value << 8 | byte;
    return value;
  }
  std::uint8_t byte() { return static_cast<std::uint8_t>(number(1)); }
  /// 0 .. limit - 1; limit at most 65536.
  std::int64_t below(std::int64_t limit) {
    return static_cast<std::int64_t>(number(limit > 256 ? 2 : 1)) % limit;
  }
  std::int64_t i64() { return static_cast<std::int64_t>(number(8)); }

 private:
  std::span<const std::uint8_t> bytes_;
};

}  // namespace roadbalance::fuzz
