#include "common/clock/clock_map.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/types/block.hpp"

namespace roadbalance {
namespace {

constexpr double kDrift = 40e-6;
constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::int64_t node_ns(std::int64_t host_ns) {
  return 7 * kSecond_ns + host_ns + std::llround(kDrift * static_cast<double>(host_ns));
}

ClockFit fit_at(std::int64_t host_ns, double drift = kDrift) {
  return {.node = 1,
          .epoch = 7,
          .number = 1,
          .state = ClockState::kLocked,
          .host_ns = host_ns,
          .node_ns = node_ns(host_ns),
          .drift = drift,
          .uncertainty_s = 1e-4};
}

double error_s(const ClockMap& map, std::int64_t host_ns) {
  return 1e-9 * static_cast<double>(map.host_time_ns(node_ns(host_ns)) - host_ns);
}

TEST(ClockMap, EachInstantByTheFitsAroundIt) {
  ClockMap map;
  EXPECT_FALSE(map.is_known());
  map.take(fit_at(100 * kSecond_ns));
  map.take(fit_at(160 * kSecond_ns, 0.0));  // it has just locked
  ASSERT_EQ(map.fits().size(), 2U);
  for (const std::int64_t s : {20, 90, 100, 101, 130, 159, 160})
    EXPECT_NEAR(error_s(map, s * kSecond_ns), 0.0, 5e-9) << s;
  EXPECT_NEAR(error_s(map, 161 * kSecond_ns), kDrift, 1e-8) << "behind the last one only that one tells";
  map.reset();
  EXPECT_FALSE(map.is_known());
}

// A recorder begins anew: the blocks that the node kept follow for a while, and a fit each second, the first
// of which has no drift.
TEST(ClockMap, BehindAHoleItsBeginningHoldsUntilWhatWasKeptHasCome) {
  ClockMap map;
  map.take(fit_at(99 * kSecond_ns));
  map.take(fit_at(100 * kSecond_ns));
  for (std::int64_t s = 400; s < 430; ++s) {
    map.take(fit_at(s * kSecond_ns, 0.0));
    for (const std::int64_t late : {100, 101, 250, 399})
      EXPECT_NEAR(error_s(map, late * kSecond_ns), 0.0, 5e-9) << s;
  }
  for (std::int64_t s = 430; s < 470; ++s) map.take(fit_at(s * kSecond_ns));
  EXPECT_EQ(map.fits().front().host_ns, 468 * kSecond_ns);
  ClockFit broken = fit_at(470 * kSecond_ns);
  broken.breaks = 1;
  map.take(broken);
  EXPECT_EQ(map.fits(), std::vector{broken});
}

// A recorder that is started again in the minute behind a hole has only what its segment holds.
TEST(ClockMap, TheFitsOfAMapMakeTheSameMap) {
  ClockMap map, again;
  for (std::int64_t s = 98; s < 480; ++s) {
    if (s > 100 && s < 400) continue;
    map.take(fit_at(s * kSecond_ns));
    again.take(fit_at(s * kSecond_ns));
    EXPECT_EQ(again.fits(), map.fits()) << s;
    const std::vector<ClockFit> fits = again.fits();
    EXPECT_LE(fits.size(), 3U);
    again.reset();
    for (const ClockFit& fit : fits) again.take(fit);
  }
}

TEST(ClockMap, NothingIsJoinedThatNoCrystalJoins) {
  const ClockFit before = fit_at(100 * kSecond_ns);
  const auto joins = [&](ClockFit last) {
    ClockMap map;
    map.take(before);
    map.take(last);
    return map.fits().size() == 2;
  };
  const ClockFit after = fit_at(200 * kSecond_ns);
  EXPECT_TRUE(joins(after));
  ClockFit broken = after;
  broken.breaks = 1;
  EXPECT_FALSE(joins(broken));
  ClockFit jumped = after;
  jumped.node_ns += kSecond_ns / 20;  // 500 ppm
  EXPECT_FALSE(joins(jumped));
  EXPECT_FALSE(joins(fit_at(50 * kSecond_ns))) << "the host was booted anew";
  ClockFit booted = after;
  booted.host_ns += 1000 * kSecond_ns;
  EXPECT_FALSE(joins(booted));
}

TEST(ClockMap, UncertainFitsAMomentApartTellNoSlope) {
  for (const std::int64_t off_ns : {-3 * kSecond_ns, -kSecond_ns, 5 * kSecond_ns}) {
    ClockFit first = fit_at(100 * kSecond_ns), last = fit_at(101 * kSecond_ns);
    first.uncertainty_s = last.uncertainty_s = 10.0;
    last.node_ns += off_ns;
    ClockMap map;
    map.take(first);
    map.take(last);
    EXPECT_EQ(map.fits(), std::vector{last}) << off_ns;
  }
}

TEST(ClockMap, InstantsAtTheLimitsAreBounded) {
  for (const std::int64_t host_ns : {-kClockLimit_ns, kClockLimit_ns})
    for (const std::int64_t far_ns : {-kClockLimit_ns, kClockLimit_ns}) {
      ClockFit first = fit_at(0), last = fit_at(0);
      first.host_ns = -host_ns, first.node_ns = -far_ns, last.host_ns = host_ns, last.node_ns = far_ns;
      ClockMap map;
      map.take(first);
      map.take(last);
      for (const std::int64_t node_ns : {-kClockLimit_ns, std::int64_t{0}, kClockLimit_ns})
        EXPECT_LE(std::abs(map.host_time_ns(node_ns)), kClockLimit_ns);
    }
}

}  // namespace
}  // namespace roadbalance
