#include "firmware/backends/usb/board_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace roadbalance {
namespace {

constexpr double kTickHz = 10e6;
constexpr std::uint64_t kFirstTicks = 123'456'789'000;
constexpr std::uint64_t kPacketTicks = 50'000;  // 5 ms

/// A board whose timer is `ppm` fast.
struct Timer {
  double ppm;
  double time_ns(std::uint64_t ticks) const {
    return 4e12 + static_cast<double>(ticks - kFirstTicks) * 1e9 / (kTickHz * (1.0 + 1e-6 * ppm));
  }
  NodeTime time(std::uint64_t ticks, double late_ns = 0.0) const {
    return node_time_from_ns(std::llround(time_ns(ticks) + late_ns));
  }
};

TEST(BoardClock, FindsTheInstantsWhateverTheDelaysOfReading) {
  for (const double ppm : {-80.0, 0.0, 50.0}) {
    const Timer timer{ppm};
    std::mt19937_64 random(5);
    std::exponential_distribution<double> delay_ns(1.0 / 300e3);
    BoardClock clock(kTickHz, {kFirstTicks, timer.time(kFirstTicks, 20e3)});
    for (std::uint64_t ticks = kFirstTicks + kPacketTicks; ticks < kFirstTicks + 60 * 10'000'000ull;
         ticks += kPacketTicks) {
      clock.hear({ticks, timer.time(ticks, 30e3 + delay_ns(random))});
      if (ticks < kFirstTicks + 10 * 10'000'000ull) continue;
      // The shortest delay, 30 us, is not seen; the least of 200 of 300 us on average adds 1.5 us, the hull
      // little.
      const std::uint64_t between = ticks - kPacketTicks / 3;
      ASSERT_NEAR(static_cast<double>(to_ns(clock.time(between))) - timer.time_ns(between), 30e3, 12e3)
          << ppm;
    }
    EXPECT_NEAR(clock.tick_s() * kTickHz, 1.0 - 1e-6 * ppm, 1e-6);
  }
}

TEST(BoardClock, TakesOffWhatTheFastestPacketTakesOnceTheBoardIsAsked) {
  constexpr std::uint64_t kQuestionTicks = 2'500'000;
  for (const double ppm : {-45.0, 0.0, 45.0}) {
    const Timer timer{ppm};
    std::mt19937_64 random(7);
    std::exponential_distribution<double> delay_ns(1.0 / 300e3), way_ns(1.0 / 10e3);
    BoardClock clock(kTickHz, {kFirstTicks, timer.time(kFirstTicks, -15e3)});
    for (std::uint64_t ticks = kFirstTicks + kPacketTicks; ticks < kFirstTicks + 60 * 10'000'000ull;
         ticks += kPacketTicks) {
      clock.hear({ticks, timer.time(ticks, 50e3 + delay_ns(random))});
      const std::uint64_t asked = ticks + 700;
      if ((ticks - kFirstTicks) % kQuestionTicks == 0)
        clock.compare(
            {asked, timer.time(asked, -20e3 - way_ns(random)), timer.time(asked, 20e3 + way_ns(random))});
      if (ticks < kFirstTicks + 10'000'000ull) continue;
      const std::uint64_t between = ticks - kPacketTicks / 3;
      const double late_ns = static_cast<double>(to_ns(clock.time(between))) - timer.time_ns(between);
      ASSERT_NEAR(late_ns, 0.0, 150e3) << ppm;  // half a round trip and 100 ppm of a second
      // An exchange is off by half the difference of its two ways, 7 us rms; the last few of them count.
      if (ticks > kFirstTicks + 12 * 10'000'000ull) {
        ASSERT_NEAR(late_ns, 0.0, 20e3) << ppm;
      }
    }
  }
}

TEST(BoardClock, AQuestionThatWasAnsweredLateCountsLittle) {
  const Timer timer{0.0};
  BoardClock clock(kTickHz, {kFirstTicks, timer.time(kFirstTicks)});
  for (std::uint64_t k = 1; k < 2000; ++k) {
    const std::uint64_t ticks = kFirstTicks + k * kPacketTicks;
    clock.hear({ticks, timer.time(ticks, 40e3)});
    if (k % 50 == 0)  // each eighth comes back 4 ms late
      clock.compare({ticks, timer.time(ticks, -30e3), timer.time(ticks, k % 400 == 0 ? 4e6 : 30e3)});
    if (k > 200) {
      // Its 2 ms weigh against the last one's 55 us, half a round trip and its age, as the squares: 1.5 us.
      ASSERT_NEAR(static_cast<double>(to_ns(clock.time(ticks))) - timer.time_ns(ticks), 0.0, 2e3) << k;
    }
  }
}

TEST(BoardClock, BeginsWhereTheExchangeSaid) {
  const Timer timer{0.0};
  BoardClock clock(kTickHz, {kFirstTicks, timer.time(kFirstTicks)});
  clock.hear({kFirstTicks + kPacketTicks, timer.time(kFirstTicks + kPacketTicks, 700e3)});
  EXPECT_NEAR(static_cast<double>((clock.time(kFirstTicks + 1000) - timer.time(kFirstTicks + 1000)).count()),
              0.0, 1.0);
  EXPECT_EQ(clock.tick_s(), 1e-7);
}

TEST(BoardClock, StaysWhereItWasWhenPacketsAreHandledSecondsLate) {
  const Timer timer{20.0};
  BoardClock clock(kTickHz, {kFirstTicks, timer.time(kFirstTicks)});
  for (std::uint64_t k = 1; k < 8000; ++k) {
    const std::uint64_t ticks = kFirstTicks + k * kPacketTicks;
    const bool stopped = k >= 5000 && k < 5600;  // for three seconds; then all at once
    const double late_ns = stopped ? static_cast<double>(5600 - k) * 5e6 : 10e3;
    clock.hear({ticks, timer.time(ticks, late_ns)});
    if (k <= 4000) continue;
    ASSERT_NEAR(static_cast<double>(to_ns(clock.time(ticks))) - timer.time_ns(ticks), 10e3, 10e3) << k;
  }
}

TEST(BoardClock, KnowsAStampThatCannotBe) {
  const Timer timer{50.0};
  const BoardClock clock(kTickHz, {kFirstTicks, timer.time(kFirstTicks)});
  const std::uint64_t later = kFirstTicks + 100 * 10'000'000ull;
  EXPECT_TRUE(clock.is_possible({later, timer.time(later)}));
  EXPECT_TRUE(clock.is_possible({kFirstTicks, timer.time(later)})) << "handled late";
  EXPECT_FALSE(clock.is_possible({later, timer.time(kFirstTicks)})) << "of the future";
  EXPECT_FALSE(clock.is_possible({0, timer.time(later)}));
  EXPECT_FALSE(clock.is_possible({UINT64_MAX, timer.time(later)}));
}

TEST(BoardClock, TimesRiseEvenlyOverTheEndsOfPackets) {
  const Timer timer{0.0};
  std::mt19937_64 random(6);
  std::exponential_distribution<double> delay_ns(1.0 / 300e3);
  BoardClock clock(kTickHz, {kFirstTicks, timer.time(kFirstTicks)});
  NodeTime last = clock.time(kFirstTicks);
  for (std::uint64_t ticks = kFirstTicks; ticks < kFirstTicks + 10'000'000; ticks += kPacketTicks) {
    clock.hear({ticks + kPacketTicks, timer.time(ticks + kPacketTicks, delay_ns(random))});
    for (std::uint64_t k = 1; k <= 50; ++k) {
      const NodeTime time = clock.time(ticks + k * 1000);
      ASSERT_NEAR(to_seconds(time - last) / 100e-6, 1.0, 1.1e-3);  // 0.1 % and a nanosecond's rounding
      last = time;
    }
  }
}

}  // namespace
}  // namespace roadbalance
