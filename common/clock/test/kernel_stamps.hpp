#pragma once

#include <gtest/gtest.h>

#include "common/clock/clock_socket.hpp"

namespace roadbalance {

/// Waits until the kernel stamps what comes in: it begins some milliseconds after the first socket of the machine
/// that asks for it was opened, and goes on while one of them is open.
inline void await_kernel_stamps() {
  constexpr std::uint32_t kLoopback = 0x7F000001;
  ClockSocket from(kLoopback), to(kLoopback);
  for (int i = 0; i < 2'000; ++i) {
    ASSERT_TRUE(from.send(to.address(), encode(ClockDatagram{.node = 1})));
    const auto got = to.receive(std::chrono::milliseconds(1000));
    ASSERT_TRUE(got);
    if (got->received.by_kernel) return;
    from.receive(std::chrono::milliseconds(1));  // nothing comes; it waits
  }
  FAIL() << "every Linux since 3.17 stamps on loopback";
}

}  // namespace roadbalance
