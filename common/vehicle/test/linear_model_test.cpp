#include "common/vehicle/linear_model.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "common/test/source.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;

VehicleConfig car() {
  return VehicleConfig::parse(test::read_source("sim/demo/vehicle.toml"), "vehicle.toml");
}

/// The same car, computed elsewhere: see the "source" in the file.
nlohmann::json reference() {
  return nlohmann::json::parse(test::read_source("common/vehicle/test/data/car.json"));
}

Matrix7 matrix(const nlohmann::json& rows) {
  Matrix7 m;
  for (int i = 0; i < kCoordinates; ++i)
    for (int j = 0; j < kCoordinates; ++j)
      m(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)].get<double>();
  return m;
}

LinearModel model() {
  const auto vehicle = car();
  return linear_model(geometry_of(vehicle.model), nominal_parameters(vehicle));
}

TEST(LinearModel, MatricesAreTheReferenceCars) {
  const auto numbers = reference();
  const LinearModel m = model();
  // Rounding of entries of up to 2.5e5.
  EXPECT_LT((m.M - matrix(numbers["M"])).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((m.P - matrix(numbers["P"])).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((m.Q - matrix(numbers["Q"])).cwiseAbs().maxCoeff(), 1e-9);
  for (int w = 0; w < kWheels; ++w) {
    EXPECT_EQ(m.S.col(w).sum(), w < 2 ? 215'000.0 : 210'000.0);
    EXPECT_EQ(m.S(kBodyCoordinates + w, w), m.S.col(w).sum());
    EXPECT_EQ(m.W(kBodyCoordinates + w, w), 1.0);
    EXPECT_EQ(m.W.col(w).cwiseAbs().sum(), 1.0);
  }
}

/// (1) by hand, from the strut stretches: what the derived equations must be for any car of this form.
LinearModel by_hand(const Geometry& geometry, const ParameterVector& p) {
  Eigen::Matrix<double, kWheels, kCoordinates> B = decltype(B)::Zero();
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    B.row(i).head<3>() << 1.0, geometry.y_m[w], -geometry.x_m[w];
    B(i, kBodyCoordinates + i) = -1.0;
  }
  LinearModel m;
  m.M = p.head<kCoordinates>().asDiagonal();
  m.P = B.transpose() * p.segment<kWheels>(kDamper).asDiagonal() * B;
  m.Q = B.transpose() * p.segment<kWheels>(kSpring).asDiagonal() * B;
  for (int a = 0; a < kAxles; ++a) {
    const auto twist = (B.row(2 * a) - B.row(2 * a + 1)).eval();
    m.Q += p(kStabiliser + a) * twist.transpose() * twist;
  }
  m.Q.diagonal().tail<kWheels>() += p.segment<kWheels>(kTyre);
  m.P.diagonal().tail<kWheels>() += p.segment<kWheels>(kTyreDamper);
  m.S.setZero();
  m.S.bottomRows<kWheels>() = p.segment<kWheels>(kTyre).asDiagonal();
  m.Sd.setZero();
  m.Sd.bottomRows<kWheels>() = p.segment<kWheels>(kTyreDamper).asDiagonal();
  m.W.setZero();
  m.W.bottomRows<kWheels>().setIdentity();
  return m;
}

TEST(LinearModel, IsWhatIsDerivedByHandForAnyCar) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(0.5, 2.0);
  for (int repeat = 0; repeat < 20; ++repeat) {
    Geometry geometry{};
    for (std::size_t w = 0; w < kWheels; ++w) {
      geometry.x_m[w] = (w < 2 ? 1.0 : -1.0) * number(random);
      geometry.y_m[w] = (w % 2 == 0 ? 1.0 : -1.0) * number(random);
    }
    ParameterVector p;
    for (double& value : p) value = number(random);
    const LinearModel derived = linear_model(geometry, p), expected = by_hand(geometry, p);
    // Rounding of sums of some ten entries of size 10.
    EXPECT_LT((derived.M - expected.M).norm(), 1e-12);
    EXPECT_LT((derived.P - expected.P).norm(), 1e-12);
    EXPECT_LT((derived.Q - expected.Q).norm(), 1e-12);
    EXPECT_LT((derived.S - expected.S).norm(), 1e-12);
    EXPECT_LT((derived.Sd - expected.Sd).norm(), 1e-12);
    EXPECT_EQ(derived.W, expected.W);
  }
}

TEST(LinearModel, MatricesAreSymmetricAndStable) {
  const LinearModel m = model();
  EXPECT_LT((m.P - m.P.transpose()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((m.Q - m.Q.transpose()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix7>(m.Q).eigenvalues().minCoeff(), 0.0);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix7>(m.P).eigenvalues().minCoeff(), -1e-9);
}

TEST(LinearModel, ModesAreTheReferenceCars) {
  const LinearModel m = model();
  Eigen::Matrix<double, 14, 14> state = Eigen::Matrix<double, 14, 14>::Zero();
  state.topRightCorner<7, 7>().setIdentity();
  state.bottomLeftCorner<7, 7>() = -m.M.inverse() * m.Q;
  state.bottomRightCorner<7, 7>() = -m.M.inverse() * m.P;
  std::vector<Complex> modes;
  for (const Complex& pole : state.eigenvalues())
    if (pole.imag() > 0.0) modes.push_back(pole);
  std::sort(modes.begin(), modes.end(), [](Complex a, Complex b) { return std::abs(a) < std::abs(b); });
  const auto numbers = reference()["modes_hz_zeta"];
  ASSERT_EQ(modes.size(), numbers.size());
  for (std::size_t k = 0; k < modes.size(); ++k) {
    EXPECT_NEAR(std::abs(modes[k]) / (2.0 * std::numbers::pi), numbers[k][0].get<double>(), 1e-9);
    EXPECT_NEAR(-modes[k].real() / std::abs(modes[k]), numbers[k][1].get<double>(), 1e-9);
  }
}

TEST(LinearModel, IsTheSumOfItsParametersMatrices) {
  const auto vehicle = car();
  const Geometry geometry = geometry_of(vehicle.model);
  ParameterVector p = nominal_parameters(vehicle);
  p.segment<kWheels>(kTyreDamper).setConstant(120.0);
  const LinearModel whole = linear_model(geometry, p);
  LinearModel sum = linear_model(geometry, ParameterVector::Zero());
  EXPECT_EQ(sum.M.norm() + sum.P.norm() + sum.Q.norm() + sum.S.norm() + sum.Sd.norm(), 0.0);
  for (int k = 0; k < kParameters; ++k) {
    const LinearModel unit = linear_model(geometry, ParameterVector::Unit(k));
    EXPECT_GT(unit.M.norm() + unit.P.norm() + unit.Q.norm() + unit.S.norm(), 0.0) << k;
    sum.M += p(k) * unit.M;
    sum.P += p(k) * unit.P;
    sum.Q += p(k) * unit.Q;
    sum.S += p(k) * unit.S;
    sum.Sd += p(k) * unit.Sd;
  }
  EXPECT_LT((sum.M - whole.M).norm(), 1e-9);
  EXPECT_LT((sum.P - whole.P).norm(), 1e-9);
  EXPECT_LT((sum.Q - whole.Q).norm(), 1e-9);
  EXPECT_LT((sum.S - whole.S).norm(), 1e-9);
  EXPECT_LT((sum.Sd - whole.Sd).norm(), 1e-9);
}

TEST(LinearModel, AnswersAnUnbalanceAsTheReferenceCar) {
  const LinearModel m = model();
  const double speed_rad_s = 120.0 / 3.6 / 0.30;
  const Complex unbalance_kg_m = 0.030 * 0.19 * std::polar(1.0, 40.0 * std::numbers::pi / 180.0);
  const Complex j(0.0, 1.0);
  const Eigen::Matrix<Complex, 7, 7> dynamic =
      m.Q.cast<Complex>() + j * speed_rad_s * m.P - speed_rad_s * speed_rad_s * m.M.cast<Complex>();
  const Eigen::Matrix<Complex, 7, 1> force =
      m.W.col(0).cast<Complex>() * unbalance_kg_m * speed_rad_s * speed_rad_s;
  const Eigen::Matrix<Complex, 7, 1> acceleration =
      -speed_rad_s * speed_rad_s * dynamic.partialPivLu().solve(force);
  const auto numbers = reference()["phasor_30g_40deg_FL_120kmh"];
  for (int i = 0; i < kCoordinates; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_NEAR(acceleration(i).real(), numbers["re"][k].get<double>(), 1e-10);
    EXPECT_NEAR(acceleration(i).imag(), numbers["im"][k].get<double>(), 1e-10);
  }
}

}  // namespace
}  // namespace roadbalance
