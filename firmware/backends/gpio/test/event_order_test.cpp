#include "firmware/backends/gpio/event_order.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace roadbalance {
namespace {

InputEvent event_at(std::int64_t time_ns, std::uint8_t input = 0) {
  return {.monotonic_ns = time_ns, .input = input};
}

TEST(EventOrder, HoldsWhatSomethingOlderMayStillPrecede) {
  EventOrder order(8);
  ASSERT_TRUE(order.add(event_at(10, 0)));
  ASSERT_TRUE(order.add(event_at(20, 0)));
  EXPECT_FALSE(order.take_before(10));
  ASSERT_TRUE(order.add(event_at(15, 1)));
  std::vector<std::int64_t> given;
  while (const auto event = order.take_before(20)) given.push_back(event->monotonic_ns);
  EXPECT_EQ(given, (std::vector<std::int64_t>{10, 15}));
  EXPECT_EQ(order.room(), 7U);
}

TEST(EventOrder, TakesNothingOlderThanWhatItGaveBack) {
  EventOrder order(8);
  ASSERT_TRUE(order.add(event_at(10)));
  ASSERT_TRUE(order.take_before(100));
  EXPECT_FALSE(order.add(event_at(9)));
  EXPECT_TRUE(order.add(event_at(10))) << "at the same instant is not older";
}

TEST(EventOrder, GivesAllInOrderAndThoseOfOneInstantAsTheyCame) {
  EventOrder order(256);
  std::mt19937 random(4);
  for (std::int64_t base = 0; base < 100'000; base += 1000) {
    // Two inputs, each in its own order, read one after the other; input 0's mark follows its edge.
    for (std::uint8_t input = 0; input < 2; ++input) {
      std::int64_t time_ns = base;
      for (int k = 0; k < 16; ++k) {
        time_ns += random() % 60;
        ASSERT_TRUE(order.add(event_at(time_ns, input)));
      }
      ASSERT_TRUE(order.add({.monotonic_ns = time_ns, .input = input, .kind = InputEvent::kLost}));
    }
    std::int64_t last_ns = base;
    int given = 0;
    std::array<bool, 2> closed{};
    while (const auto event = order.take_before(base + 1000)) {
      EXPECT_GE(event->monotonic_ns, last_ns);
      last_ns = event->monotonic_ns;
      EXPECT_FALSE(closed[event->input]) << "its mark came before its last edge";
      closed[event->input] = event->kind == InputEvent::kLost;
      ++given;
    }
    EXPECT_EQ(given, 34);
  }
}

}  // namespace
}  // namespace roadbalance
