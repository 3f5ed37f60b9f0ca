#include "common/clock/refine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/clock/clock_model.hpp"
#include "common/clock/test/simulated_clocks.hpp"

namespace roadbalance {
namespace {

using test::SimulatedClocks;

struct Instant {
  std::int64_t host_ns, node_ns;
};

struct Recorded {
  std::vector<ClockExchange> exchanges;
  std::vector<Instant> truth;         ///< a second apart
  std::vector<double> live_errors_s;  ///< of ClockModel's fits at the end of the second they are used for
};

double error_s(const ClockFit& fit, const Instant& instant) {
  return 1e-9 * static_cast<double>(fit.host_time_ns(instant.node_ns) - instant.host_ns);
}

Recorded record(std::uint64_t seed, double seconds, double jump_s = 0.0, double silent_s = 0.0) {
  SimulatedClocks clocks(seed);
  ClockModel model(1, 1);
  ClockFit fit;
  Recorded recorded;
  bool jumped = jump_s == 0.0;
  const double begin_s = clocks.now_s();
  for (int i = 0; clocks.now_s() < begin_s + seconds; ++i) {
    const double since_s = clocks.now_s() - begin_s;
    if (silent_s > 0.0 && std::abs(since_s - seconds / 2) < silent_s / 2) {
      clocks.pass(1.0);
      recorded.truth.push_back({clocks.host_ns(), clocks.node_ns()});
      continue;
    }
    if (!jumped && clocks.now_s() > begin_s + seconds / 2) {
      clocks.jump(jump_s);
      jumped = true;
    }
    if (const auto exchange = clocks.exchange(i)) {
      recorded.exchanges.push_back(*exchange);
      model.add(*exchange);
    }
    clocks.pass(0.125);
    if (i % 8 != 7) continue;
    recorded.truth.push_back({clocks.host_ns(), clocks.node_ns()});
    if (i > 40) recorded.live_errors_s.push_back(error_s(fit, recorded.truth.back()));
    fit = model.fit(clocks.host_ns());
  }
  return recorded;
}

/// Ways of unequal length shift all errors alike, live and later; this is what varies.
double scatter(const std::vector<double>& values) {
  double mean = 0.0, square = 0.0;
  const auto n = static_cast<double>(values.size());
  for (const double value : values) mean += value / n;
  for (const double value : values) square += (value - mean) * (value - mean) / n;
  return std::sqrt(square);
}

TEST(Refine, IsBetterThanWhatWasKnownLive) {
  int better = 0;
  constexpr int kSeeds = 20;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Recorded recorded = record(seed, 100.0);
    RefinedFits fits(refine(recorded.exchanges));
    std::vector<double> errors_s;
    for (const auto& instant : recorded.truth) {
      const ClockFit* fit = fits.at(instant.node_ns);
      ASSERT_TRUE(fit);
      errors_s.push_back(error_s(*fit, instant));
      EXPECT_LE(std::abs(errors_s.back()), fit->uncertainty_s) << seed;
    }
    better += scatter(errors_s) < scatter(recorded.live_errors_s) ? 1 : 0;
  }
  EXPECT_GE(better, kSeeds * 3 / 4);
}

/// Instants whose fit is further off than its sigma; each has to have one.
int far_off(const Recorded& recorded) {
  RefinedFits fits(refine(recorded.exchanges));
  return static_cast<int>(std::ranges::count_if(recorded.truth, [&fits](const Instant& instant) {
    const ClockFit* fit = fits.at(instant.node_ns);
    EXPECT_TRUE(fit) << instant.node_ns;
    return fit && std::abs(error_s(*fit, instant)) > fit->uncertainty_s;
  }));
}

TEST(Refine, DoesNotReachOverABreak) {
  for (const double jump_s : {-0.5, 0.5}) {
    const Recorded recorded = record(7, 60.0, jump_s);
    EXPECT_LE(far_off(recorded), 1) << jump_s;  // within the second of the jump itself
  }
}

TEST(Refine, OverASilenceTheFitsOfBothSidesHold) {
  const Recorded recorded = record(8, 180.0, 0.0, 60.0);
  RefinedFits fits(refine(recorded.exchanges));
  int silent = 0;
  for (const auto& instant : recorded.truth) {
    const ClockFit* fit = fits.at(instant.node_ns);
    ASSERT_TRUE(fit);
    const double away_s = 1e-9 * static_cast<double>(std::abs(fit->host_ns - instant.host_ns));
    EXPECT_LE(std::abs(error_s(*fit, instant)), fit->uncertainty_s + 2e-6 * away_s);
    silent += away_s > 2.0 ? 1 : 0;
  }
  EXPECT_GE(silent, 50);
}

// The laptop is booted anew while a node goes on: its clock begins again, be it up for longer than before or
// not.
TEST(Refine, EachBootOfTheHostHasFitsOfItsOwn) {
  for (const double back_s : {5.0, 50.0, 600.0, -600.0}) {
    Recorded recorded = record(9, 100.0);
    const std::int64_t middle_ns = recorded.truth[recorded.truth.size() / 2].host_ns;
    const auto back_ns = static_cast<std::int64_t>(1e9 * back_s);
    for (auto& e : recorded.exchanges)
      if (e.asked_ns >= middle_ns) e.asked_ns -= back_ns, e.heard_ns -= back_ns;
    for (auto& instant : recorded.truth)
      if (instant.host_ns >= middle_ns) instant.host_ns -= back_ns;
    EXPECT_LE(far_off(recorded), 1) << back_s;  // within the second of the boot itself
  }
}

TEST(Refine, NothingComesOfNothing) {
  EXPECT_TRUE(refine({}).empty());
  EXPECT_EQ(RefinedFits({}).at(5), nullptr);
}

}  // namespace
}  // namespace roadbalance
