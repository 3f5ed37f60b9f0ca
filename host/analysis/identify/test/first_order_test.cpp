#include "host/analysis/identify/first_order.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// Forces at equally long drives, 160 s together, over a road of class A, tyre of 215 kN/m and 0.30 m: the
/// variance of a component is 2 S_F / T with S_F = ct^2 S_u(Om), S_u = 2 pi^2 n0^2 Gd V / Om^2 below the
/// contact patch's corner 2 pi 4 V.
std::vector<FirstOrderForce> class_a(const std::vector<double>& speeds_km_h, Complex unbalance = 0.0,
                                     Complex force = 0.0) {
  std::vector<FirstOrderForce> forces;
  for (const double km_h : speeds_km_h) {
    const double V = km_h / 3.6, om = V / 0.30;
    const double patch = 1.0 + std::pow(om / (2.0 * pi * 4.0 * V), 2);
    const double height = 2.0 * pi * pi * 0.01 * 16e-6 * V / (om * om) / patch;
    const double seconds = 160.0 / static_cast<double>(speeds_km_h.size());
    forces.push_back({om, unbalance * om * om + force, 2.0 * 215e3 * 215e3 * height / seconds});
  }
  return forces;
}

// The published table's: sd(U) alone, with the force free, and of the force, for 30 g at 0.19 m.
TEST(FirstOrderFit, HasThePublishedSigmas) {
  struct Row {
    std::vector<double> speeds_km_h;
    double alone_percent, beside_percent, force_n;
  };
  const double whole = 0.030 * 0.19 / 100.0;
  for (const Row& row :
       {Row{{110, 116.7, 123.3, 130}, 3.1, 25.0, 18.0}, Row{{80, 96.7, 113.3, 130}, 3.8, 12.4, 7.7},
        Row{{60, 80, 100, 120, 140}, 3.6, 8.8, 5.8}}) {
    const FirstOrderFit fit = fit_first_order(class_a(row.speeds_km_h));
    EXPECT_NEAR(fit.sigma_equivalent_kg_m / whole, row.alone_percent, 0.06);
    EXPECT_NEAR(fit.sigma_unbalance_kg_m / whole, row.beside_percent, 0.02 * row.beside_percent);
    EXPECT_NEAR(fit.sigma_force_n, row.force_n, 0.02 * row.force_n);
  }
}

TEST(FirstOrderFit, SeparatesOverAWideRangeOfSpeedsOnly) {
  EXPECT_FALSE(fit_first_order(class_a({110, 116.7, 123.3, 130})).separable);
  EXPECT_FALSE(fit_first_order(class_a({90, 103, 117, 130})).separable);
  EXPECT_TRUE(fit_first_order(class_a({60, 80, 100, 120, 140})).separable);
  const FirstOrderFit one = fit_first_order(class_a({120}));
  EXPECT_FALSE(one.separable);
  EXPECT_TRUE(std::isinf(one.sigma_unbalance_kg_m));
  EXPECT_TRUE(std::isnan(one.unbalance_kg_m.real()) && std::isnan(one.force_n.imag()));
}

TEST(FirstOrderFit, FindsWhatTheForcesAreMadeOf) {
  const Complex unbalance = std::polar(5.7e-3, 0.7), force = std::polar(30.0, -2.0);
  const FirstOrderFit fit = fit_first_order(class_a({60, 80, 100, 120, 140}, unbalance, force));
  EXPECT_LT(std::abs(fit.unbalance_kg_m - unbalance), 1e-9 * std::abs(unbalance));
  EXPECT_LT(std::abs(fit.force_n - force), 1e-9 * std::abs(force));
}

// One equation a wheel: N U = right, so that a = U Om^2 and its variance N^-1 Om^4 / 2 a component.
TEST(FirstOrderForces, AreThoseOfTheNormalEquations) {
  HarmonicMoments moments;
  moments.normal(1, 1) = 4.0;
  ParameterVector car = ParameterVector::Zero();
  car(kWheelMass + 1) = 34.0;
  moments.right[1][1].w2(kBodyCoordinates + 1) = Complex(0.0, 2.0) / 34.0;  // M z'' of its row
  const auto forces = first_order_forces(moments, {{1.25, 1.25, -1.45, -1.45}, {0.74, -0.74, 0.74, -0.74}},
                                         car, Eigen::Vector4d(0.0, 10.0, 0.0, 0.0));
  EXPECT_LT(std::abs(forces[1].force_n - 100.0 * Complex(0.0, 0.5)), 1e-12);
  EXPECT_NEAR(forces[1].variance_n2, 1e4 * 0.25 / 2.0, 1e-9);
  EXPECT_EQ(forces[0].variance_n2, 0.0);
}

}  // namespace
}  // namespace roadbalance
