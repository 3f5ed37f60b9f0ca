#include "common/clock/clock_socket.hpp"

#include <gtest/gtest.h>

#include <system_error>

#include "common/clock/test/kernel_stamps.hpp"

namespace roadbalance {
namespace {

using std::chrono::milliseconds;
constexpr std::uint32_t kLoopback = 0x7F000001;

TEST(ClockSocket, StampsLieBetweenSendingAndHaving) {
  ClockSocket a(kLoopback), b(kLoopback);
  ASSERT_NO_FATAL_FAILURE(await_kernel_stamps());
  for (int i = 0; i < 20; ++i) {
    const auto bytes = encode(ClockDatagram{.node = 1, .number = i});
    const MachineTime begin = MachineClock::now();
    const auto sent = a.send(b.address(), bytes);
    ASSERT_TRUE(sent);
    const auto got = b.receive(milliseconds(1000));
    const MachineTime end = MachineClock::now();
    ASSERT_TRUE(got);
    EXPECT_EQ(got->from, a.address());
    ASSERT_EQ(got->size, bytes.size());
    EXPECT_EQ(decode_clock_datagram(got->bytes())->number, i);
    // Converting wall time costs the reading error of two clocks.
    const auto reading = std::chrono::microseconds(25);
    EXPECT_GE(sent->time, begin - reading);
    EXPECT_GE(got->received.time, sent->time - reading);
    EXPECT_LE(got->received.time, end + reading);
    EXPECT_TRUE(sent->by_kernel);
    EXPECT_TRUE(got->received.by_kernel);
  }
}

TEST(ClockSocket, StampsArrivalNotReading) {
  ClockSocket a(kLoopback), b(kLoopback);
  ASSERT_NO_FATAL_FAILURE(await_kernel_stamps());
  const auto bytes = encode(ClockDatagram{.node = 1});
  ASSERT_TRUE(a.send(b.address(), bytes));
  ASSERT_FALSE(a.receive(milliseconds(30)));  // b reads late
  const MachineTime late = MachineClock::now();
  const auto got = b.receive(milliseconds(0));
  ASSERT_TRUE(got);
  EXPECT_TRUE(got->received.by_kernel);
  EXPECT_LT(got->received.time, late - milliseconds(15));
}

TEST(ClockSocket, ALongerDatagramShowsItsLength) {
  ClockSocket a(kLoopback), b(kLoopback);
  ASSERT_TRUE(a.send(b.address(), std::vector<std::uint8_t>(500)));
  const auto got = b.receive(milliseconds(1000));
  ASSERT_TRUE(got);
  EXPECT_GT(got->size, kClockDatagramBytes);
  EXPECT_FALSE(b.receive(milliseconds(0)));
}

TEST(ClockSocket, NamesTheAddressItCannotHave) {
  try {
    ClockSocket foreign(0x01020304);
    FAIL() << "1.2.3.4 is not ours";
  } catch (const std::system_error& error) {
    EXPECT_NE(std::string(error.what()).find("1.2.3.4"), std::string::npos) << error.what();
  }
}

TEST(ClockSocket, KnowsItsOwnAddressOnTheWay) {
  EXPECT_EQ(address_towards({kLoopback, 9}).address, kLoopback);
}

}  // namespace
}  // namespace roadbalance
