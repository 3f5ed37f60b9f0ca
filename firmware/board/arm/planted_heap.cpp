#include <cstddef>

#include "firmware/board/arm/program.hpp"

// A program that does what the firmware must not: it shows that check_image.py would see it.

// The calls that the C library's heap and abort() make to an operating system; without these a heap does not
// even link.
extern "C" {
void* _sbrk(std::ptrdiff_t) {
  return nullptr;
}
int _kill(int, int) {
  return -1;
}
int _getpid() {
  return 1;
}
[[noreturn]] void _exit(int) {
  for (;;) {
  }
}
}

int roadbalance::board::arm::program() {
  return *new volatile int;
}
