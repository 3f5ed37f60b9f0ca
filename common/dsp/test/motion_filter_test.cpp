#include "common/dsp/motion_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>

#include "common/test/no_allocation.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;
constexpr double kRate_hz = 500.0;

/// A mass of 34 kg between a spring and damper to one input and a stiffer spring to another, the second with
/// its own mass: every term of the equation is there.
MotionEquation quarter() {
  MotionEquation e = MotionEquation::zero(2, 2);
  e.M << 34, 0, 0, 300;
  e.P << 1500, -1500, -1500, 1700;
  e.Q << 237000, -22000, -22000, 25000;
  e.B2 << 30, 0, 0, 5;
  e.B1 << 100, 10, 0, 200;
  e.B0 << 215000, 0, 0, 3000;
  return e;
}

/// Phasor of each output at `frequency_hz` with the first input at 1, by least squares over a second.
Eigen::Vector2cd measured(double frequency_hz, int input) {
  MotionFilter filter(quarter(), 1.0 / kRate_hz);
  const double theta = 2.0 * pi * frequency_hz / kRate_hz;
  const int settle = static_cast<int>(filter.settling_s(1e-9) * kRate_hz), n = 20'000;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero(), right = Eigen::Matrix2d::Zero();
  for (int k = 0; k < settle + n; ++k) {
    Eigen::Vector2d u = Eigen::Vector2d::Zero();
    u(input) = std::cos(theta * (k + 1));
    const Eigen::Vector2d y = filter.update(u);
    if (k < settle) continue;
    const Eigen::Vector2d basis(std::cos(theta * k), -std::sin(theta * k));
    normal += basis * basis.transpose();
    right += basis * y.transpose();
  }
  const Eigen::Matrix2d x = normal.inverse() * right;
  return {Complex(x(0, 0), x(1, 0)), Complex(x(0, 1), x(1, 1))};
}

// The dynamic part errs by theta^4 / 90, and by what folds at a sample rate's distance: its gain there, under
// sinc^2 and falling with 1 / s at least, is less than (theta / (2 pi - theta))^3 of that at theta, on either
// side.  The part that passes straight through is exact.
TEST(MotionFilter, HasTheFrequencyResponseOfTheEquation) {
  const MotionEquation e = quarter();
  const Eigen::Matrix2cd straight = (e.M.inverse() * e.B2).cast<Complex>();
  for (const double f : {0.5, 2.0, 8.0, 13.3, 18.0, 25.0, 60.0})
    for (const int input : {0, 1}) {
      const double theta = 2.0 * pi * f / kRate_hz;
      const Eigen::Vector2cd expected = e.response(2.0 * pi * f).col(input);
      const Eigen::Vector2cd dynamic = expected - straight.col(input);
      const double bound =
          1.1 * std::pow(theta, 4) / 90.0 + 2.0 * std::pow(theta / (2.0 * pi - theta), 3) + 1e-8;
      const Eigen::Vector2cd error = measured(f, input) - expected;
      EXPECT_LT(error.norm(), bound * dynamic.norm()) << f << " Hz, input " << input;
    }
}

TEST(MotionFilter, IsAtRestAfterItsSettlingTime) {
  MotionFilter filter(quarter(), 1.0 / kRate_hz);
  for (int k = 0; k < 5; ++k) filter.update(Eigen::Vector2d(1.0, 1.0));
  const Eigen::Vector2d kicked = filter.update(Eigen::Vector2d::Zero());
  Eigen::Vector2d y = kicked;
  for (int k = 0; k < static_cast<int>(filter.settling_s(1e-3) * kRate_hz); ++k)
    y = filter.update(Eigen::Vector2d::Zero());
  EXPECT_LT(y.norm(), 1e-2 * kicked.norm());
  filter.reset();
  EXPECT_EQ(filter.update(Eigen::Vector2d::Zero()).norm(), 0.0);
}

TEST(MotionFilter, NeverAllocates) {
  MotionFilter filter(quarter(), 1.0 / kRate_hz);
  const Eigen::VectorXd u = Eigen::Vector2d(1.0, -1.0);
  const test::NoAllocation guard;
  for (int k = 0; k < 100; ++k) filter.update(u);
}

TEST(MotionFilter, RefusesWhatDoesNotDecayOrHasNoMass) {
  MotionEquation e = quarter();
  e.P.setZero();
  EXPECT_THROW(MotionFilter(e, 0.002), std::invalid_argument);
  e = quarter();
  e.M(0, 0) = 0.0;
  EXPECT_THROW(MotionFilter(e, 0.002), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
