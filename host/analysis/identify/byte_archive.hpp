#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace roadbalance {

/// Values of this build one behind the other.  ByteReader takes what ByteWriter takes, so one function can do
/// both ways.
class ByteWriter {
 public:
  template <typename Value>
  void operator()(Value& value) {
    static_assert(std::is_arithmetic_v<Value> || std::is_enum_v<Value>);
    put(&value, sizeof value);
  }
  void numbers(double* first, std::size_t count) { put(first, count * sizeof(double)); }
  void text(std::string& value) {
    std::uint64_t size = value.size();
    (*this)(size);
    put(value.data(), value.size());
  }
  /// Room for so many values of that size.
  static std::size_t most(std::size_t /*size*/) { return SIZE_MAX; }
  std::vector<char> bytes;

 private:
  void put(const void* from, std::size_t size) {
    const char* const begin = static_cast<const char*>(from);
    bytes.insert(bytes.end(), begin, begin + size);
  }
};

/// @throws std::length_error where bytes are missing
class ByteReader {
 public:
  explicit ByteReader(std::span<const char> bytes) : left_(bytes) {}
  template <typename Value>
  void operator()(Value& value) {
    static_assert(std::is_arithmetic_v<Value> || std::is_enum_v<Value>);
    take(&value, sizeof value);
  }
  void numbers(double* first, std::size_t count) { take(first, count * sizeof(double)); }
  void text(std::string& value) {
    std::uint64_t size = 0;
    (*this)(size);
    if (size > left_.size()) throw std::length_error("too short");
    value.assign(left_.data(), size);
    left_ = left_.subspan(size);
  }
  std::size_t most(std::size_t /*size*/) const { return left_.size(); }
  bool ended() const { return left_.empty(); }
  std::span<const char> left() const { return left_; }

 private:
  void take(void* to, std::size_t size) {
    if (size > left_.size()) throw std::length_error("too short");
    std::memcpy(to, left_.data(), size);
    left_ = left_.subspan(size);
  }
  std::span<const char> left_;
};

}  // namespace roadbalance
