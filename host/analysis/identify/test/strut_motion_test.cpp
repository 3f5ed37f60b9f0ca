#include "host/analysis/identify/strut_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "common/types/angle_units.hpp"

namespace roadbalance {
namespace {

constexpr double kRate_hz = 500.0;

/// Phasor of the rate's tanh, which is rate / kSmooth_m_s where that is small, per phasor of the true rate.
std::complex<double> transfer(double f_hz, double constant_m_s2 = 0.0) {
  constexpr double kRate_m_s = 1e-3 * StrutMotion::kSmooth_m_s;
  const double omega = kTurn * f_hz;
  StrutMotion motion(Eigen::MatrixXd::Identity(kWheels, kWheels), kRate_hz);
  Eigen::ArrayXd signals(kStrutSignals);
  std::complex<double> sum = 0.0;
  const auto settled = std::lround(60.0 * kRate_hz);
  const auto turns = std::lround(10.0 * kRate_hz / f_hz);
  for (long k = 0; k < settled + turns; ++k) {
    const double phase = omega * static_cast<double>(k) / kRate_hz;
    motion.update(Eigen::ArrayXd::Constant(kWheels, constant_m_s2 - kRate_m_s * omega * std::sin(phase)),
                  signals);
    if (k >= settled) sum += signals(0) * std::polar(1.0, -phase);
  }
  return 2.0 * sum / static_cast<double>(turns) * StrutMotion::kSmooth_m_s / kRate_m_s;
}

// Where the body moves most a lead of 0.01 rad would make a spring of friction.
TEST(StrutMotion, RateLeadsByNoMoreThanTheCubeOfTheCorner) {
  for (const double f_hz : {0.8, 1.0, 2.0, 5.0}) {
    const double cube = std::pow(0.1 / f_hz, 3);
    EXPECT_LT(std::abs(std::arg(transfer(f_hz))), 3.2 * cube + 1e-4) << f_hz;
    EXPECT_NEAR(std::abs(transfer(f_hz)), 1.0, 2.5 * std::pow(0.1 / f_hz, 2) + 1e-3) << f_hz;
  }
}

TEST(StrutMotion, SensorsThatAreOffMakeNoRate) {
  EXPECT_NEAR(std::abs(transfer(1.0, 0.05) - transfer(1.0)), 0.0, 1e-3);
}

}  // namespace
}  // namespace roadbalance
