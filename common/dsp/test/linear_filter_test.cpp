#include "common/dsp/linear_filter.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <nlohmann/json.hpp>
#include <unsupported/Eigen/MatrixFunctions>

#include "common/test/source.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;

nlohmann::json reference() {
  return nlohmann::json::parse(test::read_source("common/dsp/test/data/butterworth_5_30hz.json"));
}

Eigen::VectorXcd response(const ContinuousFilter& filter, double frequency_hz) {
  const Complex s(0.0, 2.0 * std::numbers::pi * frequency_hz);
  const Eigen::MatrixXcd identity = Eigen::MatrixXcd::Identity(filter.F.rows(), filter.F.cols());
  return (s * identity - filter.F.cast<Complex>()).partialPivLu().solve(filter.G.cast<Complex>().eval());
}

TEST(Butterworth, HasTheClosedFormMagnitude) {
  for (int order = 1; order <= 12; ++order) {
    const auto filter = butterworth(order, 200.0);
    for (const double f : {0.0, 20.0, 150.0, 200.0, 250.0, 800.0}) {
      const double expected = 1.0 / (1.0 + std::pow(f / 200.0, 2 * order));
      EXPECT_NEAR(std::norm(response(filter, f)(0)) / expected, 1.0, 1e-9) << order << " at " << f;
    }
  }
}

TEST(Butterworth, StatesAreTheDerivativesOfTheOutput) {
  const auto filter = butterworth(6, 200.0);
  for (const double f : {10.0, 100.0, 400.0}) {
    const auto states = response(filter, f);
    for (int k = 1; k < 6; ++k)
      EXPECT_LT(std::abs(states(k) / states(0) / std::pow(Complex(0.0, f / 200.0), k) - 1.0), 1e-9);
  }
}

TEST(Butterworth, PolesLieOnTheLeftHalfOfACircle) {
  const auto filter = butterworth(7, 10.0);
  const Eigen::VectorXcd poles = filter.F.eigenvalues();
  for (const Complex& pole : poles) {
    EXPECT_NEAR(std::abs(pole) / (2.0 * std::numbers::pi * 10.0), 1.0, 1e-9);
    EXPECT_LT(pole.real(), 0.0);
  }
}

TEST(Butterworth, EqualsThePublishedMatrices) {
  const auto numbers = reference();
  const auto filter = butterworth(5, 30.0);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(filter.G(i), numbers["G"][static_cast<std::size_t>(i)].get<double>(), 1e-9);
    for (int j = 0; j < 5; ++j)
      EXPECT_NEAR(filter.F(i, j),
                  numbers["F"][static_cast<std::size_t>(i)][static_cast<std::size_t>(j)].get<double>(), 1e-9);
  }
}

TEST(Butterworth, RefusesWhatIsNoFilter) {
  EXPECT_THROW(butterworth(0, 10.0), std::invalid_argument);
  EXPECT_THROW(butterworth(13, 10.0), std::invalid_argument);
  EXPECT_THROW(butterworth(4, 0.0), std::invalid_argument);
  EXPECT_THROW(butterworth(4, NAN), std::invalid_argument);
  EXPECT_THROW(discretise_ramp_invariant(butterworth(2, 1.0), 0.0), std::invalid_argument);
}

TEST(RampInvariant, EqualsThePublishedTransferFunctions) {
  const auto numbers = reference();
  const auto filter = discretise_ramp_invariant(butterworth(5, 30.0), 1.0 / 500.0);
  const auto polynomial = [](const nlohmann::json& coefficients, Complex z) {
    Complex sum = 0.0;
    for (const auto& c : coefficients) sum = sum * z + c.get<double>();
    return sum;
  };
  for (const double f : {0.0, 5.0, 30.0, 100.0, 250.0}) {
    const Complex z = std::polar(1.0, 2.0 * std::numbers::pi * f / 500.0);
    const Eigen::MatrixXcd left = z * Eigen::MatrixXcd::Identity(5, 5) - filter.A.cast<Complex>();
    const Eigen::VectorXcd right = filter.b0.cast<Complex>() + z * filter.b1.cast<Complex>();
    const Eigen::VectorXcd states = left.partialPivLu().solve(right);
    const Complex denominator = polynomial(numbers["foh_denominator"], z);
    for (std::size_t k = 0; k < 5; ++k) {
      const Complex expected = polynomial(numbers["foh_numerators"][k], z) / denominator;
      // The denominator's small value at low frequency (1e-4 of its terms) magnifies the file's rounding.
      EXPECT_LT(std::abs(states(static_cast<Eigen::Index>(k)) - expected), 1e-10) << f << ", state " << k;
    }
  }
}

TEST(RampInvariant, HasTheClosedFormOfAFirstOrderFilter) {
  const double a = 3.0;
  const double h = 0.1;
  const ContinuousFilter lag{Eigen::MatrixXd::Constant(1, 1, -a), Eigen::VectorXd::Constant(1, a)};
  const auto filter = discretise_ramp_invariant(lag, h);
  const double e = std::exp(-a * h);
  const double mean = (1.0 - e) / (a * h);
  EXPECT_NEAR(filter.A(0, 0), e, 1e-15);
  EXPECT_NEAR(filter.b0(0), mean - e, 1e-15);
  EXPECT_NEAR(filter.b1(0), 1.0 - mean, 1e-15);
}

TEST(RampInvariant, IsExactForARamp) {
  const auto continuous = butterworth(5, 30.0);
  const double h = 1.0 / 500.0;
  const auto filter = discretise_ramp_invariant(continuous, h);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(5);
  const Eigen::MatrixXd inverse = continuous.F.inverse();
  for (int k = 1; k <= 100; ++k) {
    const double t = k * h;
    x = filter.A * x + filter.b0 * (t - h) + filter.b1 * t;
    // x' = F x + G t from rest: x = -F^-1 G t + F^-2 (exp(F t) - 1) G.
    const Eigen::MatrixXd grown = (continuous.F * t).exp() - Eigen::MatrixXd::Identity(5, 5);
    const Eigen::VectorXd exact = -inverse * continuous.G * t + inverse * inverse * grown * continuous.G;
    // Rounding of the condition of F^-2, about 100, on values of up to 0.2.
    EXPECT_LT((x - exact).norm(), 1e-13) << k;
  }
}

}  // namespace
}  // namespace roadbalance
