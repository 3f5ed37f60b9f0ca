#include "firmware/backends/socketcan/hardware_stamps.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

namespace roadbalance {
namespace {

TEST(HardwareStamps, RemovesTheKernelsDelayFromAClockThatRunsByItself) {
  // The controller's clock is 50 ppm fast; the kernel stamps 20 us later and up to 3 ms more.
  HardwareStamps stamps;
  std::mt19937 random(5);
  std::exponential_distribution<double> late_us(1.0 / 200.0);
  NodeTime last = NodeTime::min();
  double worst_us = 0.0;
  for (std::int64_t k = 0; k < 60'000; ++k) {
    const std::int64_t came_ns = 7'000'000'000 + k * 1'000'000;
    const std::int64_t hardware_ns = 900'000'000'000'000 + k * 1'000'000 + k * 50;
    const double delay_us = 20.0 + std::min(3'000.0, late_us(random));
    const NodeTime time =
        stamps.time(hardware_ns, node_time_from_ns(came_ns + static_cast<std::int64_t>(1e3 * delay_us)));
    EXPECT_GE(time, last);
    last = time;
    // Once the line has found its slope: the shortest delay stays, and of 1000 frames a second the earliest
    // is within 1 us of it; the line through such points of 32 s is better still, up to rounding.
    if (k > 40'000)
      worst_us = std::max(worst_us, std::abs(static_cast<double>(to_ns(time) - came_ns) / 1e3 - 20.0));
  }
  EXPECT_LT(worst_us, 3.0);
}

}  // namespace
}  // namespace roadbalance
