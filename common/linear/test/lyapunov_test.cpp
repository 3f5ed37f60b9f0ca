#include "common/linear/lyapunov.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <random>
#include <stdexcept>

#include "common/linear/test/slicot_examples.hpp"

namespace roadbalance {
namespace {

using Eigen::MatrixXd;
namespace slicot = test::slicot;

double largest(const MatrixXd& difference) {
  return difference.cwiseAbs().maxCoeff();
}

/// Its diagonal is positive, as SLICOT has it.
MatrixXd cholesky(const MatrixXd& X) {
  return X.llt().matrixU();
}

MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

TEST(Slicot, Sb03mdAndSb03sdAreReproduced) {
  EXPECT_LT(largest(discrete_lyapunov(slicot::kA.transpose(), -slicot::kC) - slicot::kSb03mdX),
            slicot::kPrinted);
}

TEST(Slicot, Sb03qdIsReproduced) {
  EXPECT_LT(largest(continuous_lyapunov(slicot::kA.transpose(), -slicot::kC) - slicot::kSb03qdX),
            slicot::kPrinted);
}

TEST(Slicot, Sb03odIsReproduced) {
  const MatrixXd X =
      continuous_lyapunov(slicot::kSb03odA.transpose(), slicot::kSb03odB.transpose() * slicot::kSb03odB);
  EXPECT_LT(largest(X - slicot::kSb03odX), slicot::kPrinted);
  EXPECT_LT(largest(cholesky(X).transpose() - slicot::kSb03odUTransposed), slicot::kPrinted);
}

TEST(Slicot, Sg03adIsReproduced) {
  const MatrixXd X =
      continuous_lyapunov(slicot::kSg03adA.transpose(), slicot::kSg03adE.transpose(), -slicot::kSg03adY);
  EXPECT_LT(largest(X - slicot::kSg03adX), slicot::kPrinted);
}

TEST(Slicot, Sg03bdIsReproduced) {
  const MatrixXd X = continuous_lyapunov(slicot::kSg03bdA.transpose(), slicot::kSg03bdE.transpose(),
                                         slicot::kSg03bdB.transpose() * slicot::kSg03bdB);
  EXPECT_LT(largest(cholesky(X) - slicot::kSg03bdU), slicot::kPrinted);
}

TEST(Lyapunov, OfAnOscillatorInNoiseIsTheClosedForm) {
  // m x'' + d x' + k x = w, E[w w] = q delta: E[x^2] = q / (2 d k), E[x'^2] = q / (2 d m), E[x x'] = 0.
  const double m = 34.0, d = 1500.0, k = 2.4e5, q = 7.0;
  MatrixXd A(2, 2), C = MatrixXd::Zero(2, 2);
  A << 0.0, 1.0, -k / m, -d / m;
  C(1, 1) = q / (m * m);
  const MatrixXd X = continuous_lyapunov(A, C);
  EXPECT_NEAR(X(0, 0) * 2.0 * d * k / q, 1.0, 1e-12);
  EXPECT_NEAR(X(1, 1) * 2.0 * d * m / q, 1.0, 1e-12);
  EXPECT_LT(std::abs(X(0, 1)), 1e-14 * std::sqrt(X(0, 0) * X(1, 1)));
  // The same as m x'' = ...: E = diag(1, m).
  MatrixXd E = MatrixXd::Identity(2, 2), A1 = A, C1 = C;
  E(1, 1) = m;
  A1.row(1) *= m;
  C1(1, 1) = q;
  const MatrixXd X1 = continuous_lyapunov(A1, E, C1);
  EXPECT_NEAR(X1(0, 0) / X(0, 0), 1.0, 1e-12);
  EXPECT_NEAR(X1(1, 1) / X(1, 1), 1.0, 1e-12);
}

TEST(Lyapunov, OfAFirstOrderProcessIsTheClosedForm) {
  const MatrixXd a = MatrixXd::Constant(1, 1, 0.9), c = MatrixXd::Constant(1, 1, 2.0);
  EXPECT_NEAR(discrete_lyapunov(a, c)(0, 0), 2.0 / (1.0 - 0.81), 1e-13);
  const MatrixXd e = MatrixXd::Constant(1, 1, 2.0);  // 2 x[k+1] = 0.9 x[k] + w
  EXPECT_NEAR(discrete_lyapunov(a, e, c)(0, 0), 2.0 / (4.0 - 0.81), 1e-13);
}

TEST(Sylvester, HoldsForMatricesOfAllShapes) {
  for (const auto& [m, n] : {std::pair{1, 1}, {5, 3}, {3, 5}, {20, 20}}) {
    const MatrixXd A = random_matrix(m, m, 1) - 10.0 * MatrixXd::Identity(m, m);
    const MatrixXd B = random_matrix(n, n, 2) - 10.0 * MatrixXd::Identity(n, n);
    const MatrixXd C = random_matrix(m, n, 3);
    EXPECT_LT(largest(A * solve_sylvester(A, B, C) + solve_sylvester(A, B, C) * B - C), 1e-13);
    const MatrixXd X = solve_stein(0.05 * A, 0.05 * B, C);
    EXPECT_LT(largest(0.0025 * A * X * B.transpose() - X - C), 1e-13);
  }
}

TEST(Lyapunov, RefusesWhatHasNoSolution) {
  MatrixXd A(2, 2);
  A << 1.0, 0.0, 0.0, -1.0;  // 1 + (-1) = 0
  const MatrixXd C = MatrixXd::Identity(2, 2);
  EXPECT_THROW(continuous_lyapunov(A, C), std::domain_error);
  EXPECT_THROW(discrete_lyapunov(A, C), std::domain_error);
  EXPECT_THROW(continuous_lyapunov(-C, MatrixXd::Zero(2, 2), C), std::domain_error);
  EXPECT_THROW(continuous_lyapunov(MatrixXd::Zero(2, 3), C), std::invalid_argument);
  EXPECT_THROW(continuous_lyapunov(-C, MatrixXd::Identity(3, 3)), std::invalid_argument);
  EXPECT_THROW(continuous_lyapunov(-C, MatrixXd::Identity(3, 3), C), std::invalid_argument);
}

}  // namespace
}  // namespace roadbalance
