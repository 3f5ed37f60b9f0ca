#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/record/file.hpp"

namespace roadbalance {

/// A file that is written front to back through a buffer, numbers in little endian.
class ByteSink {
 public:
  explicit ByteSink(const std::filesystem::path& path) : file_(File::create(path)) {
    buffer_.reserve(kBuffer);
  }

  /// Bytes written so far: the offset of the next one.
  std::uint64_t offset() const { return written_ + buffer_.size(); }

  void put(std::span<const std::uint8_t> bytes) {
    if (buffer_.size() + bytes.size() > kBuffer) flush();
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
  void put(std::string_view text) { put({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}); }
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void put(Number number) {
    static_assert(std::endian::native == std::endian::little);
    std::array<std::uint8_t, sizeof number> bytes;
    std::memcpy(bytes.data(), &number, sizeof number);
    put(std::span<const std::uint8_t>(bytes));
  }
  void zeros(std::size_t count) {
    for (; count > 0; --count) put(std::uint8_t{0});
  }
  /// Replaces bytes that were put before.
  void put_at(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
    flush();
    file_.write_all_at(offset, bytes);
  }

  void close() {
    flush();
    file_.close();
  }

 private:
  static constexpr std::size_t kBuffer = 1 << 20;

  void flush() {
    file_.write_all(buffer_);
    written_ += buffer_.size();
    buffer_.clear();
  }

  File file_;
  std::vector<std::uint8_t> buffer_;
  std::uint64_t written_ = 0;
};

}  // namespace roadbalance
