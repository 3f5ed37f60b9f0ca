#include "host/analysis/orders/angle_sampler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/analysis/orders/test/sweep.hpp"

namespace roadbalance {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kRateHz = 600.0;
constexpr AngleSampler::Settings kSettings{1, kRateHz, 128, 5.0};

Eigen::VectorXd one(double value) {
  return Eigen::VectorXd::Constant(1, value);
}

TEST(AngleSampler, InterpolatesBandLimitedSignalsAtConstantSteps) {
  const test::Sweep wheel{10.0, 0.5};
  // A tone at 0.37 of the rate, which no order is: where a row lies in time is what is tested.
  const double tone_rad_s = kTurn_rad * 0.37 * kRateHz;
  double worst_s = 0.0, worst = 0.0;
  std::int64_t next = -1;
  AngleSampler sampler(kSettings, [&](const AngleRow& row) {
    EXPECT_TRUE(next < 0 || row.index == next) << row.index;
    next = row.index + 1;
    const double time_s = wheel.time_s(static_cast<double>(row.index) / kSettings.rows_per_turn);
    worst_s = std::max(worst_s, std::abs(row.time_s - time_s));
    worst = std::max(worst, std::abs(row.values(0) - std::cos(tone_rad_s * time_s)));
  });
  for (int k = 0; k < 36'000; ++k) {
    const double t = k / kRateHz;
    sampler.add(kTurn_rad * (wheel.turns(t) - std::floor(wheel.turns(t))), one(std::cos(tone_rad_s * t)));
  }
  EXPECT_GT(next, 128 * 1499) << "1500 turns";
  // The angle is a parabola, which the cubic follows: rounding is left.  A thousandth of a microsecond is
  // 1e-5 degrees at 40 turns a second.
  EXPECT_LT(worst_s, 1e-9);
  EXPECT_LT(worst, 5e-5);  // FractionalDelay is a pure delay to 3e-5 in gain and 2e-5 in phase
}

TEST(AngleSampler, FollowsTorsionWithinTheErrorOfTheCubic) {
  // 1 degree at 13 Hz: (3/128) T^4 angle'''' with T = 1/600 s is 1.4e-7 rad.
  const double amplitude_rad = 1.0 / 57.3, torsion_rad_s = kTurn_rad * 13.0;
  const auto angle = [&](double t) {
    return kTurn_rad * 12.0 * t + amplitude_rad * std::sin(torsion_rad_s * t);
  };
  const double bound_rad = 3.0 / 128.0 * amplitude_rad * std::pow(torsion_rad_s / kRateHz, 4);
  double worst_rad = 0.0;
  AngleSampler sampler(kSettings, [&](const AngleRow& row) {
    const double wanted = kTurn_rad * static_cast<double>(row.index) / kSettings.rows_per_turn;
    worst_rad = std::max(worst_rad, std::abs(angle(row.time_s) - wanted));
  });
  for (int k = 0; k < 6000; ++k) sampler.add(angle(k / kRateHz), one(0.0));
  EXPECT_LT(worst_rad, 1.05 * bound_rad);
  EXPECT_GT(worst_rad, 0.5 * bound_rad) << "the error stated is the error there is";
}

struct Rows {
  std::vector<AngleRow> row;
  std::vector<std::size_t> restarts;  ///< places of rows
  AngleSampler sampler{kSettings, [this](const AngleRow& r) {
                         if (r.restart) restarts.push_back(row.size());
                         row.push_back(r);
                       }};
};

TEST(AngleSampler, MakesNoRowWhereTheAngleIsNotKnownOrSamplesAreMissing) {
  Rows rows;
  for (int k = 0; k < 1800; ++k) {
    const double t = k / kRateHz;
    const bool known = k < 600 || k >= 700;
    if (k == 1200) rows.sampler.interrupt();
    rows.sampler.add(known ? std::optional(kTurn_rad * 10.0 * t) : std::nullopt, one(known ? 1.0 : 1e6));
  }
  ASSERT_EQ(rows.restarts.size(), 3U);
  for (const AngleRow& row : rows.row) ASSERT_NEAR(row.values(0), 1.0, 1e-9);
  // From the 16th sample of a run to the 16th before its end.
  const auto seconds = [&](std::size_t i) { return rows.row[i].time_s; };
  EXPECT_NEAR(seconds(rows.restarts[1] - 1) * kRateHz, 600 - 17, 1.0);
  EXPECT_NEAR(seconds(rows.restarts[1]) * kRateHz, 700 + 15, 1.0);
  EXPECT_NEAR(seconds(rows.restarts[2] - 1) * kRateHz, 1200 - 17, 1.0);
  EXPECT_NEAR(seconds(rows.restarts[2]) * kRateHz, 1200 + 15, 1.0);
}

TEST(AngleSampler, StandstillAndReversalInterrupt) {
  Rows rows;
  double angle = 1.0;
  const auto turn = [&](double rotation_hz, double seconds) {
    for (int k = 0; k < std::lround(seconds * kRateHz); ++k) {
      angle += kTurn_rad * rotation_hz / kRateHz;
      rows.sampler.add(angle, one(0.0));
    }
  };
  turn(10.0, 2.0);
  turn(0.0, 3.0);
  turn(10.0, 2.0);
  turn(-10.0, 2.0);
  turn(10.0, 2.0);
  EXPECT_EQ(rows.restarts.size(), 3U);
  // 3 + 2 s and, of four turning points, the samples around that are slow on the whole: 16 at most.
  EXPECT_NEAR(static_cast<double>(rows.sampler.slow_samples()), 5.0 * kRateHz, 4 * 16.0);
  const double step_s = 1.0 / kRateHz;  // the first to turn leads from the last that stands
  for (const AngleRow& row : rows.row) {
    const double t = row.time_s;
    EXPECT_TRUE(t < 2.0 || (t > 5.0 - step_s && t < 7.0) || t > 9.0 - step_s) << t;
  }
}

TEST(AngleSampler, SaysWhichChannelsLeftTheirRange) {
  Rows rows;
  for (int k = 0; k < 600; ++k)
    rows.sampler.add(kTurn_rad * 10.0 * k / kRateHz, one(0.0), k == 300 ? 0b100U : 0U);
  for (const AngleRow& row : rows.row) {
    const auto before = static_cast<int>(std::floor(row.time_s * kRateHz + 1e-9));
    EXPECT_EQ(row.overload, before >= 300 - 16 && before <= 300 + 15 ? 0b100U : 0U) << before;
  }
}

TEST(AngleSampler, RefusesToFold) {
  EXPECT_THROW(AngleSampler({1, kRateHz, 100, 5.0}, {}), std::invalid_argument);
  EXPECT_THROW(AngleSampler({0, kRateHz, 128, 5.0}, {}), std::invalid_argument);
  EXPECT_THROW(AngleSampler({1, kRateHz, 128, 0.0}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
