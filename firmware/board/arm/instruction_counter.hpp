#pragma once

#include <cstdint>

namespace roadbalance::board::arm {

/// Counts executed instructions by the processor's SysTick, under QEMU with `-icount shift=6` only.
///
/// There an instruction lasts 2^6 = 64 ns of the emulator's time and SysTick has 25 MHz: 1.6 ticks to an
/// instruction, so that none is lost in rounding.  It is 24 bit wide: at most 10 million instructions.
class InstructionCounter {
 public:
  InstructionCounter() {
    *reload() = kMask;
    *current() = 0;
    *control() = kEnable | kProcessorClock;
    start();
    own_ = 0;
    own_ = count();
  }

  void start() { begun_ = *current(); }

  /// Since start(), without what start() and count() themselves take.
  std::uint32_t count() const {
    const std::uint32_t ticks = (begun_ - *current()) & kMask;
    return (ticks * 5 + 4) / 8 - own_;
  }

 private:
  using Register = volatile std::uint32_t*;
  static Register control() { return reinterpret_cast<Register>(0xE000E010); }
  static Register reload() { return reinterpret_cast<Register>(0xE000E014); }
  static Register current() { return reinterpret_cast<Register>(0xE000E018); }
  static constexpr std::uint32_t kMask = 0xFFFFFF;
  static constexpr std::uint32_t kEnable = 1u << 0;
  static constexpr std::uint32_t kProcessorClock = 1u << 2;

  std::uint32_t begun_ = 0;
  std::uint32_t own_ = 0;
};

}  // namespace roadbalance::board::arm
