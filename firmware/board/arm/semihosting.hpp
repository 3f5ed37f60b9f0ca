#pragma once

#include <cstdint>

/// The debugger's services, which QEMU has, too.  Source: Arm, Semihosting for AArch32 and AArch64, 2.0.
namespace roadbalance::board::arm {

std::uint32_t semihost(std::uint32_t operation, const void* argument);

/// Ends the emulator with this exit code.
[[noreturn]] void exit_with(int code);

}  // namespace roadbalance::board::arm
