#include "common/vehicle/linear_model.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

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
  const ParameterVector p = nominal_parameters(vehicle);
  const LinearModel whole = linear_model(geometry, p);
  LinearModel sum = linear_model(geometry, ParameterVector::Zero());
  EXPECT_EQ(sum.M.norm() + sum.P.norm() + sum.Q.norm() + sum.S.norm(), 0.0);
  for (int k = 0; k < kParameters; ++k) {
    const LinearModel unit = linear_model(geometry, ParameterVector::Unit(k));
    EXPECT_GT(unit.M.norm() + unit.P.norm() + unit.Q.norm() + unit.S.norm(), 0.0) << k;
    sum.M += p(k) * unit.M;
    sum.P += p(k) * unit.P;
    sum.Q += p(k) * unit.Q;
    sum.S += p(k) * unit.S;
  }
  EXPECT_LT((sum.M - whole.M).norm(), 1e-9);
  EXPECT_LT((sum.P - whole.P).norm(), 1e-9);
  EXPECT_LT((sum.Q - whole.Q).norm(), 1e-9);
  EXPECT_LT((sum.S - whole.S).norm(), 1e-9);
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
