#include "common/clock/clock_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "common/clock/test/simulated_clocks.hpp"

namespace roadbalance {
namespace {

using test::SimulatedClocks;

/// Asks as the recorder does, for `seconds`: 16 questions at 50 Hz, then 8 a second.
class Asking {
 public:
  Asking(SimulatedClocks& clocks, ClockModel& model) : clocks_(clocks), model_(model) {}

  int run(double seconds) {
    int breaks = 0;
    for (const double end_s = clocks_.now_s() + seconds; clocks_.now_s() < end_s;) {
      const auto exchange = clocks_.exchange(++number_);
      if (!exchange)
        model_.add_unanswered();
      else if (model_.add(*exchange))
        ++breaks;
      clocks_.pass(number_ <= 16 ? 0.02 : 0.125);
    }
    return breaks;
  }

 private:
  SimulatedClocks& clocks_;
  ClockModel& model_;
  std::int64_t number_ = 0;
};

double error_s(const ClockFit& fit, const SimulatedClocks& clocks) {
  return std::abs(1e-9 * static_cast<double>(fit.host_time_ns(clocks.node_ns()) - clocks.host_ns()));
}

TEST(ClockModel, StatedUncertaintyCoversTheError) {
  int windows = 0, covered = 0;
  std::vector<double> errors, uncertainties;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    SimulatedClocks clocks(seed);
    ClockModel model(1, 1);
    Asking asking(clocks, model);
    asking.run(0.5);
    for (int second = 0; second < 100; ++second) {
      const ClockFit fit = model.fit(clocks.host_ns());
      bool inside = error_s(fit, clocks) <= fit.uncertainty_s;
      errors.push_back(error_s(fit, clocks));
      uncertainties.push_back(fit.uncertainty_s);
      asking.run(1.0);  // the fit is used until the next one comes
      inside = inside && error_s(fit, clocks) <= fit.uncertainty_s;
      if (fit.state != ClockState::kLocked) continue;
      ++windows;
      covered += inside ? 1 : 0;
    }
  }
  std::sort(errors.begin(), errors.end());
  std::sort(uncertainties.begin(), uncertainties.end());
  std::printf("windows %d covered %.4f %%; error p50 %.1f us p99 %.1f us; u p50 %.1f us\n", windows,
              100.0 * covered / windows, 1e6 * errors[errors.size() / 2],
              1e6 * errors[errors.size() * 99 / 100], 1e6 * uncertainties[uncertainties.size() / 2]);
  EXPECT_GT(windows, 14'000);
  EXPECT_GE(covered, windows * 0.999);
  // And it is no idle bound: half the shortest round trip alone is 100 us here on average.
  EXPECT_LT(uncertainties[uncertainties.size() / 2], 300e-6);
}

TEST(ClockModel, AcquiresLocksAndHolds) {
  SimulatedClocks clocks(3);
  ClockModel model(1, 1);
  EXPECT_EQ(model.fit(clocks.host_ns()).state, ClockState::kAcquire);
  Asking asking(clocks, model);
  asking.run(40.0);
  const ClockFit locked = model.fit(clocks.host_ns());
  EXPECT_EQ(locked.state, ClockState::kLocked);
  clocks.pass(60.0);
  const ClockFit held = model.fit(clocks.host_ns());
  EXPECT_EQ(held.state, ClockState::kHoldover);
  EXPECT_GT(held.uncertainty_s, locked.uncertainty_s + 25e-6);  // 0.5 ppm for a minute, at least
  EXPECT_LE(error_s(held, clocks), held.uncertainty_s);
  EXPECT_EQ(held.number, locked.number + 1);
  asking.run(1.0);
  EXPECT_EQ(model.fit(clocks.host_ns()).state, ClockState::kLocked);
  EXPECT_EQ(model.breaks(), 0);
}

TEST(ClockModel, KeepsTheDriftOverASilence) {
  SimulatedClocks clocks(4);
  ClockModel model(1, 1);
  Asking asking(clocks, model);
  asking.run(60.0);
  const double drift = model.fit(clocks.host_ns()).drift;
  clocks.pass(120.0);
  asking.run(0.3);
  EXPECT_NEAR(model.fit(clocks.host_ns()).drift, drift, 5e-6);  // of up to 50e-6
  EXPECT_EQ(model.breaks(), 0);
}

TEST(ClockModel, ABreakIsDeclaredAndNeverSmeared) {
  for (const double jump_s : {5e-3, -0.3, 3600.0}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      SimulatedClocks clocks(seed);
      ClockModel model(1, 1);
      Asking asking(clocks, model);
      ASSERT_EQ(asking.run(40.0), 0) << seed;
      clocks.jump(jump_s);
      EXPECT_EQ(asking.run(4.0), 1) << seed;
      const ClockFit after = model.fit(clocks.host_ns());
      EXPECT_EQ(after.breaks, 1);
      EXPECT_EQ(after.state, ClockState::kLocked);
      EXPECT_LE(error_s(after, clocks), after.uncertainty_s) << seed;
    }
  }
}

TEST(ClockModel, CongestionAloneIsNoBreak) {
  for (std::uint64_t seed = 100; seed < 140; ++seed) {
    SimulatedClocks clocks(seed);
    ClockModel model(1, 1);
    Asking asking(clocks, model);
    EXPECT_EQ(asking.run(60.0), 0) << seed;
  }
}

TEST(ClockModel, OneImpossibleExchangeChangesNothing) {
  SimulatedClocks clocks(5);
  ClockModel model(1, 1), same(1, 1);
  for (int i = 0; i < 100; ++i) {
    const auto exchange = clocks.exchange(i);
    clocks.pass(0.1);
    if (!exchange) continue;
    model.add(*exchange);
    same.add(*exchange);
    if (i != 60) continue;
    ClockExchange far_off = *exchange;  // proves a jump, but nothing after it does
    far_off.received_ns += 1'000'000'000;
    far_off.answered_ns += 1'000'000'000;
    EXPECT_FALSE(model.add(far_off));
    ClockExchange backwards = *exchange;
    std::swap(backwards.asked_ns, backwards.heard_ns);
    EXPECT_FALSE(model.add(backwards));
  }
  const ClockFit a = model.fit(clocks.host_ns()), b = same.fit(clocks.host_ns());
  EXPECT_EQ(a.node_ns, b.node_ns);
  EXPECT_EQ(a.drift, b.drift);
  EXPECT_EQ(a.breaks, 0);
}

}  // namespace
}  // namespace roadbalance
