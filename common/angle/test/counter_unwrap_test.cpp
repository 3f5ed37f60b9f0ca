#include "common/angle/counter_unwrap.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <stdexcept>

namespace roadbalance {
namespace {

using Outcome = CounterUnwrap::Outcome;
constexpr std::int64_t kPeriod_ns = 20'000'000;

/// 96 teeth, 1.885 m a turn: 20 +- 10 m/s within 30 s, in closed form.
double pulses_at(double t) {
  const double w = 2.0 * std::numbers::pi / 30.0;
  return 96.0 / 1.885 * (20.0 * t - 10.0 / w * (std::cos(w * t) - 1.0));
}
std::int64_t count_at(double t) {
  return static_cast<std::int64_t>(std::floor(pulses_at(t)));
}

TEST(CounterUnwrap, FollowsTenBitsThroughWrapsInvalidCodesAndLostMessages) {
  CounterUnwrap counter({});
  std::mt19937 random(5);
  std::int64_t invalid = 0, taken = 0, first = 0;
  for (int n = 0; n < 3000; ++n) {
    const double t = 0.02 * n;
    const std::int64_t code = count_at(t) % 1024;
    if (random() % 10 == 0 || n % 500 > 490) continue;  // lost, once in a while nine in a row
    const bool valid = random() % 20 != 0;
    const auto outcome = counter.take(n * kPeriod_ns, code, valid);
    if (!valid || code == 0x3FF) {
      ++invalid;
      ASSERT_EQ(outcome, Outcome::kInvalid);
      continue;
    }
    if (taken++ == 0) first = count_at(t);
    ASSERT_EQ(outcome, taken == 1 ? Outcome::kFirst : Outcome::kJoined) << n;
    ASSERT_EQ(counter.count(), count_at(t) - first) << n;
  }
  EXPECT_EQ(counter.run(), 1);
  EXPECT_EQ(counter.counters().invalid, invalid);
  EXPECT_EQ(counter.counters().joined, taken - 1);
  EXPECT_EQ(counter.counters().wraps, (first + counter.count()) / 1024 - first / 1024);
  EXPECT_GT(counter.counters().wraps, 50);
}

TEST(CounterUnwrap, JoinsNothingWhereAWrapMayHaveBeenMissedUnlessTheSpeedTellsIt) {
  const auto drive = [](std::optional<RateBounds> known) {
    CounterUnwrap counter({});
    for (int n = 0; n < 50; ++n)  // 1000 counts a second
      EXPECT_NE(counter.take(n * kPeriod_ns, 20 * n % 1024), Outcome::kAmbiguous);
    const std::int64_t later = 49 + 150;  // 3 s without a message: 3000 counts
    const auto outcome = counter.take(later * kPeriod_ns, 20 * later % 1024, true, known);
    return std::pair(outcome, counter);
  };
  const auto [blind, alone] = drive(std::nullopt);
  EXPECT_EQ(blind, Outcome::kAmbiguous);
  EXPECT_EQ(alone.run(), 2);
  EXPECT_EQ(alone.count(), 0);
  EXPECT_EQ(alone.counters().ambiguous, 1);
  const auto [seeing, told] = drive(RateBounds{.low_hz = 950.0, .high_hz = 1050.0});
  EXPECT_EQ(seeing, Outcome::kJoined);
  EXPECT_EQ(told.run(), 1);
  EXPECT_EQ(told.count(), 20 * (49 + 150));
}

TEST(CounterUnwrap, BeginsAgainAfterAResetOfTheControlUnit) {
  CounterUnwrap counter({});
  for (int n = 0; n < 20; ++n)
    EXPECT_EQ(counter.take(n * kPeriod_ns, 400 + 20 * n) == Outcome::kFirst, n == 0);
  EXPECT_EQ(counter.take(20 * kPeriod_ns, 5), Outcome::kImplausible);
  EXPECT_EQ(counter.run(), 2);
  EXPECT_EQ(counter.take(21 * kPeriod_ns, 25), Outcome::kJoined);
  EXPECT_EQ(counter.count(), 20);
}

TEST(CounterUnwrap, ContradictsASpeedThatCannotBe) {
  CounterUnwrap counter({});
  EXPECT_EQ(counter.take(0, 100), Outcome::kFirst);
  EXPECT_EQ(counter.take(kPeriod_ns, 120, true, RateBounds{.low_hz = 0.0, .high_hz = 100.0}),
            Outcome::kImplausible);
}

TEST(CounterUnwrap, StandsStillAndKnowsAnOldMessage) {
  CounterUnwrap counter({});
  for (int n = 0; n < 500; ++n) counter.take(n * kPeriod_ns, 77);
  EXPECT_EQ(counter.take(499 * kPeriod_ns, 78), Outcome::kOutOfOrder);
  EXPECT_EQ(counter.take(3 * kPeriod_ns, 78), Outcome::kOutOfOrder);
  EXPECT_EQ(counter.count(), 0);
  EXPECT_EQ(counter.run(), 1);
  EXPECT_EQ(counter.take(500 * kPeriod_ns, 78), Outcome::kJoined);
  EXPECT_EQ(counter.count(), 1);
}

TEST(CounterUnwrap, RefusesCodesThatCannotBeAndFormsThatCannotBe) {
  CounterUnwrap counter({.modulus = 1000, .invalid_code = std::nullopt});
  EXPECT_EQ(counter.take(0, 1000), Outcome::kInvalid);
  EXPECT_EQ(counter.take(1, -1), Outcome::kInvalid);
  EXPECT_EQ(counter.take(2, 999), Outcome::kFirst);
  EXPECT_THROW(CounterUnwrap({.modulus = 1}), std::invalid_argument);
  EXPECT_THROW(CounterUnwrap({.step = 0}), std::invalid_argument);
  EXPECT_THROW(CounterUnwrap({.highest_rate_hz = 0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
