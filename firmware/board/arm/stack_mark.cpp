#include "firmware/board/arm/stack_mark.hpp"

namespace roadbalance::board::arm {
namespace {

constexpr std::uint32_t kPattern = 0x5AC35AC3;
constexpr std::uint32_t kMarkedWords = 16 * 1024;

volatile std::uint32_t* mark_begin = nullptr;

volatile std::uint32_t* stack_pointer() {
  std::uint32_t* pointer;
  asm volatile("mov %0, sp" : "=r"(pointer));
  return pointer;
}

}  // namespace

void mark_stack() {
  mark_begin = stack_pointer();
  for (std::uint32_t k = 1; k <= kMarkedWords; ++k) *(mark_begin - k) = kPattern;
}

std::uint32_t stack_used() {
  std::uint32_t untouched = 0;
  while (untouched < kMarkedWords && *(mark_begin - kMarkedWords + untouched) == kPattern) ++untouched;
  return (kMarkedWords - untouched) * sizeof(std::uint32_t);
}

}  // namespace roadbalance::board::arm
