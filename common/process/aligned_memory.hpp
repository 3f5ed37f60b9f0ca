#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <new>
#include <vector>

namespace roadbalance {

inline constexpr std::size_t kCacheLine = 64;  ///< bytes; the widest lanes have as many

/// For arrays that are gone through again and again: they begin with a line of the cache, so that no vector
/// of the widest lanes lies in two.  Those of megabytes are on huge pages where the kernel gives some, so
/// that the processor need not look up where each 4 KB of them lie; it is only asked, and what it does not
/// give is on pages as all else.
template <typename Value>
struct AlignedMemory {
  using value_type = Value;

  AlignedMemory() = default;
  template <typename Other>
  AlignedMemory(const AlignedMemory<Other>&) {}

  Value* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(Value);
    Value* const memory = static_cast<Value*>(::operator new(bytes, boundary(bytes)));
    if (bytes >= kPage) ::madvise(memory, bytes, MADV_HUGEPAGE);
    return memory;
  }
  void deallocate(Value* memory, std::size_t count) {
    ::operator delete(memory, boundary(count * sizeof(Value)));
  }
  bool operator==(const AlignedMemory&) const = default;

 private:
  static constexpr std::size_t kPage = std::size_t{2} << 20;

  static constexpr std::align_val_t boundary(std::size_t bytes) {
    return std::align_val_t(bytes >= kPage ? kPage : std::max(kCacheLine, alignof(Value)));
  }
};

template <typename Value>
using AlignedVector = std::vector<Value, AlignedMemory<Value>>;

}  // namespace roadbalance
