#include "common/dsp/taper.hpp"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

constexpr double kStep_s = 0.002;

TEST(Taper, IsOneInTheMiddleAndSymmetric) {
  const Taper taper = c2_taper(1'000, 0.1, kStep_s);
  EXPECT_TRUE((taper.value.segment(100, 800) == 1.0).all());
  EXPECT_TRUE((taper.first.segment(100, 800) == 0.0).all());
  EXPECT_LT((taper.value - taper.value.reverse()).abs().maxCoeff(), 1e-15);
  EXPECT_LT((taper.first + taper.first.reverse()).abs().maxCoeff(), 1e-12);
  EXPECT_LT((taper.second - taper.second.reverse()).abs().maxCoeff(), 1e-10);
}

TEST(Taper, RisesByTheSmoothStep) {
  const Taper taper = c2_taper(1'000, 0.1, kStep_s);
  for (int k = 0; k < 100; ++k) {
    const double x = (k + 0.5) / 100.0;
    EXPECT_NEAR(taper.value(k), 6 * std::pow(x, 5) - 15 * std::pow(x, 4) + 10 * std::pow(x, 3), 1e-14);
  }
}

TEST(Taper, DerivativesAreThoseOfTheValue) {
  const Taper taper = c2_taper(2'000, 0.2, kStep_s);
  const double rise_s = 400 * kStep_s;
  for (Eigen::Index k = 1; k + 1 < taper.value.size(); ++k) {
    const double first = (taper.value(k + 1) - taper.value(k - 1)) / (2.0 * kStep_s);
    const double second = (taper.first(k + 1) - taper.first(k - 1)) / (2.0 * kStep_s);
    // Central differences err by h^2/6 times the third derivative (60 / rise^3) of the value, and by h/2
    // times the jump of the third derivative of the value (60 / rise^3) at the corners of the second.
    EXPECT_NEAR(taper.first(k), first, 10.0 * kStep_s * kStep_s / std::pow(rise_s, 3) + 1e-12) << k;
    EXPECT_NEAR(taper.second(k), second, 30.0 * kStep_s / std::pow(rise_s, 3) + 1e-9) << k;
  }
}

TEST(Taper, LeavesNoEndTermsInIntegrationByParts) {
  // h'' x + 2 h' x' + h x'' = (h x)'' integrates to zero for any smooth x; here x = exp(a t).
  const int samples = 5'000;
  const double a = 0.7;
  const Taper taper = c2_taper(samples, 0.1, kStep_s);
  double sum = 0.0;
  double size = 0.0;
  for (int k = 0; k < samples; ++k) {
    const double x = std::exp(a * (k + 0.5) * kStep_s);
    const double term = (taper.second(k) + 2.0 * a * taper.first(k) + a * a * taper.value(k)) * x;
    sum += term;
    size += std::abs(term);
  }
  EXPECT_LT(std::abs(sum), 1e-5 * size);  // midpoint rule: (step / rise)^2 = 4e-6
}

TEST(Taper, RefusesWhatIsNoTaper) {
  EXPECT_THROW(c2_taper(1, 0.1, kStep_s), std::invalid_argument);
  EXPECT_THROW(c2_taper(10, 0.0, kStep_s), std::invalid_argument);
  EXPECT_THROW(c2_taper(10, 0.6, kStep_s), std::invalid_argument);
  EXPECT_THROW(c2_taper(10, 0.5, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
