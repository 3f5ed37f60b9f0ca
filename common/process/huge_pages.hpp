#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <new>
#include <vector>

namespace roadbalance {

/// For arrays of megabytes that are gone through again and again: on huge pages where the kernel gives some,
/// so that the processor need not look up where each 4 KB of them lie.  The kernel is only asked: what it
/// does not give is on pages as all else.
template <typename Value>
struct HugePages {
  using value_type = Value;

  HugePages() = default;
  template <typename Other>
  HugePages(const HugePages<Other>&) {}

  Value* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(Value);
    const std::size_t boundary = bytes >= kPage ? kPage : alignof(Value);
    Value* const memory = static_cast<Value*>(::operator new(bytes, std::align_val_t(boundary)));
    if (bytes >= kPage) ::madvise(memory, bytes, MADV_HUGEPAGE);
    return memory;
  }
  void deallocate(Value* memory, std::size_t count) {
    ::operator delete(memory, std::align_val_t(count * sizeof(Value) >= kPage ? kPage : alignof(Value)));
  }
  bool operator==(const HugePages&) const = default;

 private:
  static constexpr std::size_t kPage = std::size_t{2} << 20;
};

template <typename Value>
using HugeVector = std::vector<Value, HugePages<Value>>;

}  // namespace roadbalance
