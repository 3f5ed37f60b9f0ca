#include <cstdint>

#include "firmware/board/arm/program.hpp"
#include "firmware/board/arm/semihosting.hpp"
#include "firmware/board/test/check.hpp"

// Runs before program() on a bare Cortex-M7.

extern "C" {
extern std::uint32_t stack_top[], data_begin[], data_end[], data_in_flash[], bss_begin[], bss_end[];
extern void (*init_array_begin[])();
extern void (*init_array_end[])();

[[noreturn]] void reset();

// The C library's assert() ends here.
[[noreturn]] void __assert_func(const char* file, int line, const char*, const char* expression) {
  roadbalance::board::test::fail(file, line, expression);
  roadbalance::board::arm::exit_with(98);
}
}

namespace {

[[noreturn]] void fault() {
  roadbalance::board::test::print("the processor faulted\n");
  roadbalance::board::arm::exit_with(99);
}

// CP10 and CP11, the FPU: off after reset.
void switch_fpu_on() {
  auto* const coprocessor_access = reinterpret_cast<volatile std::uint32_t*>(0xE000ED88);
  *coprocessor_access = *coprocessor_access | 0xFu << 20;
  asm volatile("dsb\n isb" ::: "memory");
}

}  // namespace

void reset() {
  switch_fpu_on();
  const std::uint32_t* from = data_in_flash;
  for (std::uint32_t* to = data_begin; to < data_end; ++to) *to = *from++;
  for (std::uint32_t* to = bss_begin; to < bss_end; ++to) *to = 0;
  for (auto run = init_array_begin; run < init_array_end; ++run) (*run)();
  roadbalance::board::arm::exit_with(roadbalance::board::arm::program());
}

// Reset, NMI and the five faults; interrupts are not used here.
extern "C" {
using Handler = void (*)();
struct Vectors {
  std::uint32_t* stack;
  Handler handlers[15];
};
[[gnu::section(".vectors"), gnu::used]] const Vectors vectors = {
    stack_top, {reset, fault, fault, fault, fault, fault, fault}};
}
