#include "host/analysis/orders/angle_resampler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/analysis/orders/test/sweep.hpp"

namespace roadbalance {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kRateHz = 600.0;
constexpr int kRows = 32;
constexpr AngleSampler::Settings kSettings{1, kRateHz, kRows, 5.0};

/// Largest difference of the rows from what `expected` gives for their angle, in turns.
double worst_error(const test::OrderSignal& signal, const test::Sweep& wheel, double seconds) {
  double worst = 0.0;
  std::int64_t rows = 0;
  AngleResampler resampler(kSettings, [&](const AngleRow& row) {
    const double turns = static_cast<double>(row.index) / kRows;
    worst = std::max(worst, std::abs(row.values(0) - signal.at(turns)));
    EXPECT_NEAR(row.time_s, wheel.time_s(turns), 1e-9);
    ++rows;
  });
  for (int k = 0; k < std::lround(seconds * kRateHz); ++k) {
    const double turns = wheel.turns(k / kRateHz);
    resampler.add(kTurn_rad * turns, Eigen::VectorXd::Constant(1, signal.at(turns)));
  }
  EXPECT_NEAR(static_cast<double>(rows), kRows * (wheel.turns(seconds) - wheel.turns(0.0)), 3.0 * kRows);
  return worst;
}

TEST(AngleResampler, PassesOrdersUnchangedAndInPlace) {
  const test::Sweep wheel{10.0, 0.5};
  for (const double order : {0.5, 1.0, std::numbers::sqrt2, 2.0, 5.0})
    // 2e-4 of the low-pass, 5e-5 of FractionalDelay: 40 turns a second times 5 are 0.33 of the rate.
    EXPECT_LT(worst_error({order, 1.0, 0.4}, wheel, 60.0), 2.5e-4) << order;
}

TEST(AngleResampler, LetsNothingFold) {
  // Order 30.5 would show as 1.5 in 32 rows a turn.  At 7 turns a second it is 213 Hz, within the samples'
  // band.
  const test::Sweep wheel{7.0, 0.0};
  double worst = 0.0;
  AngleResampler resampler(kSettings,
                           [&](const AngleRow& row) { worst = std::max(worst, std::abs(row.values(0))); });
  const test::OrderSignal signal{30.5, 1.0};
  for (int k = 0; k < 6000; ++k) {
    const double turns = wheel.turns(k / kRateHz);
    resampler.add(kTurn_rad * turns, Eigen::VectorXd::Constant(1, signal.at(turns)));
  }
  EXPECT_LT(worst, 2.5e-4);
  EXPECT_GT(worst, 0.0);
}

TEST(AngleResampler, ForgetsWhatLiesBeforeAnInterruption) {
  int restarts = 0;
  bool second = false;
  AngleResampler resampler(kSettings, [&](const AngleRow& row) {
    restarts += row.restart;
    EXPECT_NEAR(row.values(0), second ? -1.0 : 1.0, 1e-9);
  });
  for (const double value : {1.0, -1.0}) {
    second = value < 0.0;
    for (int k = 0; k < 600; ++k)
      resampler.add(kTurn_rad * 10.0 * k / kRateHz, Eigen::VectorXd::Constant(1, value));
    resampler.interrupt();
  }
  EXPECT_EQ(restarts, 2);
}

}  // namespace
}  // namespace roadbalance
