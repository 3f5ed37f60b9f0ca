#include "firmware/board/arm/semihosting.hpp"

#include "firmware/board/test/check.hpp"

namespace roadbalance::board::arm {

std::uint32_t semihost(std::uint32_t operation, const void* argument) {
  register std::uint32_t r0 asm("r0") = operation;
  register const void* r1 asm("r1") = argument;
  asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

void exit_with(int code) {
  constexpr std::uint32_t kExitExtended = 0x20;
  constexpr std::uint32_t kApplicationExit = 0x20026;
  const std::uint32_t block[2] = {kApplicationExit, static_cast<std::uint32_t>(code)};
  for (;;) semihost(kExitExtended, block);
}

}  // namespace roadbalance::board::arm

namespace roadbalance::board::test {

void print(const char* text) {
  constexpr std::uint32_t kWrite0 = 0x04;
  arm::semihost(kWrite0, text);
}

}  // namespace roadbalance::board::test
