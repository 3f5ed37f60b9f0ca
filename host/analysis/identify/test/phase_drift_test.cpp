#include "host/analysis/identify/phase_drift.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::array<bool, kWheels> kAll{true, true, true, true};

/// A stretch in which wheel i is ahead of the front left one by from(i) .. to(i), degrees.
SignalMatrix stretch(const Eigen::Vector4d& from, const Eigen::Vector4d& to) {
  constexpr int kSamples = 5000;
  SignalMatrix signals = SignalMatrix::Zero(kSignals, kSamples);
  for (int k = 0; k < kSamples; ++k)
    for (int i = 0; i < kWheels; ++i) {
      const double ahead = from(i) + (to(i) - from(i)) * k / (kSamples - 1);
      const auto r = std::polar(1.0, 0.2 * k + ahead * kDegree);
      signals(cosine_row(i), k) = r.real();
      signals(sine_row(i), k) = r.imag();
    }
  return signals;
}

TEST(PhaseDrift, IsTheArcThatHoldsAllAnglesBetweenTwoWheels) {
  PhaseDrift drift;
  EXPECT_FALSE(drift.drift_rad(0, 1));
  drift.add(stretch({0, 350.5, 10, 0}, {0, 375.5, 400, 20}), kAll);
  EXPECT_NEAR(*drift.drift_rad(0, 1), 25.0 * kDegree, 1.01 * kDegree) << "across the turn's end";
  EXPECT_NEAR(*drift.drift_rad(1, 0), *drift.drift_rad(0, 1), 1e-12);
  EXPECT_NEAR(*drift.drift_rad(0, 2), 360.0 * kDegree, 1e-9) << "more than a turn";
  EXPECT_NEAR(*drift.drift_rad(1, 3), 5.0 * kDegree, 1.01 * kDegree) << "35 to 40 degrees all the time";
}

TEST(PhaseDrift, OfStretchesThatNeedNotJoin) {
  PhaseDrift drift;
  drift.add(stretch({0, 10, 0, 0}, {0, 12, 0, 0}), kAll);
  EXPECT_EQ(in_step(drift)[0], 1);
  drift.add(stretch({0, 55, 0, 0}, {0, 57, 0, 0}), kAll);
  EXPECT_NEAR(*drift.drift_rad(0, 1), 47.0 * kDegree, 1.01 * kDegree);
  EXPECT_EQ(in_step(drift)[0], 2) << "the rear wheels never moved against the front left one";
  EXPECT_FALSE(in_step(drift)[1]);
}

TEST(PhaseDrift, LeavesOutWheelsWithoutAnAngle) {
  PhaseDrift drift;
  drift.add(stretch({0, 0, 0, 0}, {0, 0, 0, 0}), {true, false, true, false});
  EXPECT_FALSE(drift.drift_rad(0, 1));
  EXPECT_EQ(in_step(drift)[0], 2);
  EXPECT_FALSE(in_step(drift)[1]);
}

}  // namespace
}  // namespace roadbalance
