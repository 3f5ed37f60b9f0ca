#include "host/analysis/orders/anti_aliasing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace roadbalance {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(AntiAliasing, HasTheResponseOfButterworth) {
  for (const int order : {4, 6, 8}) {
    const AntiAliasing filter({order, 200.0});
    for (const double f : {1.0, 18.0, 100.0, 200.0, 400.0})
      EXPECT_NEAR(std::abs(filter.response(f)), 1.0 / std::sqrt(1.0 + std::pow(f / 200.0, 2 * order)), 1e-9);
    EXPECT_NEAR(std::arg(filter.response(200.0) * std::polar(1.0, order * 45.0 * kDegree)), 0.0, 1e-9)
        << "45 degrees a pole at the cut-off";
    EXPECT_NEAR(std::abs(filter.response(filter.flat_to_hz())), 0.99, 1e-9);
  }
}

TEST(AntiAliasing, LeavesThePhaseOfTheFirstOrder) {
  const AntiAliasing filter({8, 100.0});
  for (const double f : {2.0, 18.0, 60.0, 90.0})
    EXPECT_NEAR(std::arg(filter.on_order(1.0, f)), 0.0, 1e-9) << f;
}

TEST(AntiAliasing, DelaysOtherOrdersByTheCurvatureOfThePhase) {
  // phi(x) = -(a1 x + a3 x^3 + ...), x = f / fc, a3 = 1 / (3 sin(3 pi / 2n)): order 2 is off by -6 a3 x^3.
  const AntiAliasing filter({6, 200.0});
  const double x = 18.0 / 200.0, a3 = 1.0 / (3.0 * std::sin(std::numbers::pi / 4.0));
  EXPECT_NEAR(std::arg(filter.on_order(2.0, 18.0)) / -(6.0 * a3 * x * x * x), 1.0, 0.05);
  EXPECT_NEAR(std::arg(filter.on_order(2.0, 18.0)) / kDegree, -0.12, 0.01) << "as the header says";
  EXPECT_NEAR(std::arg(filter.on_order(2.0, 40.0)) / kDegree, -1.4, 0.1);
}

TEST(AntiAliasing, KeepsCountOfHalfTurnsForOrdersThatAreNoWholeNumber) {
  // Order 8 at 100 Hz delays 90 Hz by more than half a turn; half of that must not jump with the wrap.
  const AntiAliasing filter({8, 100.0});
  double before = 0.0;
  for (double f = 1.0; f < 95.0; f += 0.5) {
    const double phase = std::arg(filter.on_order(0.5, f));
    EXPECT_NEAR(phase, before, 0.1) << f;
    before = phase;
  }
}

}  // namespace
}  // namespace roadbalance
