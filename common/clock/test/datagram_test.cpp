#include "common/clock/datagram.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "common/test/bit_flips.hpp"
#include "common/types/block.hpp"

namespace roadbalance {
namespace {

std::vector<std::uint8_t> bytes_of(const ClockDatagram& datagram) {
  const auto bytes = encode(datagram);
  return {bytes.begin(), bytes.end()};
}

ClockDatagram answer() {
  return {.kind = ClockDatagramKind::kAnswer,
          .received_by_kernel = true,
          .node = 3,
          .epoch = -7,
          .number = 1LL << 40,
          .received_ns = -5,
          .answered_ns = kClockLimit_ns};
}

TEST(ClockDatagram, ArrivesAsItWasSent) {
  for (const auto kind : {ClockDatagramKind::kAnswer, ClockDatagramKind::kFollowUp}) {
    ClockDatagram sent = answer();
    sent.kind = kind;
    EXPECT_EQ(decode_clock_datagram(bytes_of(sent)), sent);
  }
  const ClockDatagram question{.node = kLastNode, .epoch = 1, .number = 0};
  EXPECT_EQ(decode_clock_datagram(bytes_of(question)), question);
}

TEST(ClockDatagram, HasTheLayoutThatItsHeaderStates) {
  const auto bytes = encode(answer());
  const std::vector<std::uint8_t> expected{'R', 'B', 'C', 'K', 1,   2,   1,   0,   0,   0,
                                           0,   3,   255, 255, 255, 255, 255, 255, 255, 249};
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), bytes.begin()));
}

TEST(ClockDatagram, RefusesEverySingleBitFlip) {
  test::expect_every_bit_flip_refused(bytes_of(answer()), decode_clock_datagram);
}

TEST(ClockDatagram, RefusesWhatIsOutOfBoundsThoughItsCrcIsGood) {
  const auto refused = [](auto change) {
    ClockDatagram datagram = answer();
    change(datagram);
    return !decode_clock_datagram(bytes_of(datagram));
  };
  EXPECT_TRUE(refused([](auto& d) { d.node = 0; }));
  EXPECT_TRUE(refused([](auto& d) { d.node = kLastNode + 1; }));
  EXPECT_TRUE(refused([](auto& d) { d.number = -1; }));
  EXPECT_TRUE(refused([](auto& d) { d.number = kIndexLimit + 1; }));
  EXPECT_TRUE(refused([](auto& d) { d.received_ns = -kClockLimit_ns - 1; }));
  EXPECT_TRUE(refused([](auto& d) { d.answered_ns = kClockLimit_ns + 1; }));
  EXPECT_TRUE(refused([](auto& d) { d.kind = static_cast<ClockDatagramKind>(4); }));
  EXPECT_TRUE(refused([](auto& d) { d.kind = ClockDatagramKind::kQuestion; }));  // with stamps
}

}  // namespace
}  // namespace roadbalance
