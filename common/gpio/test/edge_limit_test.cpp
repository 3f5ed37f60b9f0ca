#include "common/gpio/edge_limit.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

// The kernel's first GPIO interface keeps 16 events of a line.
TEST(EdgeLimit, IsSixteenEdgesForEachWakeUpOfTheReader) {
  EXPECT_NEAR(edge_limit_hz({.interrupt_thread = microseconds(1), .reader = microseconds(800)}), 20e3, 1e-6);
  EXPECT_NEAR(edge_limit_hz({.interrupt_thread = microseconds(10), .reader = milliseconds(16)}), 1e3, 1e-6);
}

// Its interrupt handler keeps one stamp until the thread has taken it.
TEST(EdgeLimit, IsOneEdgeForEachWakeUpOfTheInterruptThread) {
  EXPECT_NEAR(edge_limit_hz({.interrupt_thread = microseconds(100), .reader = microseconds(100)}), 10e3,
              1e-6);
  EXPECT_NEAR(edge_limit_hz({.interrupt_thread = milliseconds(1), .reader = microseconds(50)}), 1e3, 1e-6);
}

}  // namespace
}  // namespace roadbalance
