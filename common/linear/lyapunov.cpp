#include "common/linear/lyapunov.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <complex>
#include <limits>
#include <stdexcept>

namespace roadbalance {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

/// A matrix in Schur form: U T U^H.
struct Schur {
  MatrixXcd U, T;

  explicit Schur(const MatrixXd& A) {
    if (A.rows() == 0 || A.rows() != A.cols())
      throw std::invalid_argument("lyapunov: a matrix is not square");
    const Eigen::ComplexSchur<MatrixXcd> schur(A.cast<std::complex<double>>());
    if (schur.info() != Eigen::Success) throw std::domain_error("lyapunov: no Schur form");
    U = schur.matrixU();
    T = schur.matrixT();
  }
};

void expect_rows_and_columns(const MatrixXd& C, Index rows, Index columns) {
  if (C.rows() != rows || C.cols() != columns)
    throw std::invalid_argument("lyapunov: the right side does not fit");
}

/// Solves the upper triangular system t x = b.
/// @param size  of the numbers that t's diagonal is a difference of
VectorXcd solve_column(const MatrixXcd& t, const VectorXcd& b, double size) {
  const double least = t.diagonal().cwiseAbs().minCoeff();
  if (!(least > 10.0 * std::numeric_limits<double>::epsilon() * size))
    throw std::domain_error("lyapunov: the equation has no unique solution");
  return t.triangularView<Eigen::Upper>().solve(b);
}

/// T Y + Y R^H = D, columns from the last to the first.
MatrixXcd solve_sum(const MatrixXcd& T, const MatrixXcd& R, const MatrixXcd& D) {
  MatrixXcd Y(T.rows(), R.rows());
  const double size = T.cwiseAbs().maxCoeff() + R.cwiseAbs().maxCoeff();
  for (Index k = R.rows() - 1; k >= 0; --k) {
    const Index done = R.rows() - 1 - k;
    const VectorXcd b = D.col(k) - Y.rightCols(done) * R.row(k).tail(done).adjoint();
    MatrixXcd t = T;
    t.diagonal().array() += std::conj(R(k, k));
    Y.col(k) = solve_column(t, b, size);
  }
  return Y;
}

/// T Y R^H - Y = D, columns from the last to the first.
MatrixXcd solve_product(const MatrixXcd& T, const MatrixXcd& R, const MatrixXcd& D) {
  MatrixXcd Y(T.rows(), R.rows());
  const double size = T.cwiseAbs().maxCoeff() * R.cwiseAbs().maxCoeff() + 1.0;
  for (Index k = R.rows() - 1; k >= 0; --k) {
    const Index done = R.rows() - 1 - k;
    const VectorXcd b = D.col(k) - T * (Y.rightCols(done) * R.row(k).tail(done).adjoint());
    MatrixXcd t = std::conj(R(k, k)) * T;
    t.diagonal().array() -= 1.0;
    Y.col(k) = solve_column(t, b, size);
  }
  return Y;
}

/// Solves, then once more for what the equation leaves.
template <typename Solve, typename Residual>
MatrixXd refined(const MatrixXd& C, const Solve& solve, const Residual& left_of) {
  MatrixXd X = solve(C);
  X += solve(C - left_of(X));
  return X;
}

MatrixXd symmetric(const MatrixXd& X) {
  return 0.5 * (X + X.transpose());
}

/// E^-1, for equations whose E is divided out.
Eigen::PartialPivLU<MatrixXd> inverse_of(const MatrixXd& E, const MatrixXd& A) {
  if (E.rows() == 0 || E.rows() != E.cols() || A.rows() != E.rows() || A.cols() != E.cols())
    throw std::invalid_argument("lyapunov: E does not fit A");
  const Eigen::PartialPivLU<MatrixXd> factors(E);
  if (!(factors.rcond() > 10.0 * std::numeric_limits<double>::epsilon()))
    throw std::domain_error("lyapunov: E is singular");
  return factors;
}

}  // namespace

MatrixXd solve_sylvester(const MatrixXd& A, const MatrixXd& B, const MatrixXd& C) {
  const Schur a(A), b(B.transpose());
  expect_rows_and_columns(C, A.rows(), B.rows());
  return refined(
      C,
      [&](const MatrixXd& right) -> MatrixXd {
        return (a.U * solve_sum(a.T, b.T, a.U.adjoint() * right * b.U) * b.U.adjoint()).real();
      },
      [&](const MatrixXd& X) -> MatrixXd { return A * X + X * B; });
}

MatrixXd solve_stein(const MatrixXd& A, const MatrixXd& B, const MatrixXd& C) {
  const Schur a(A), b(B);
  expect_rows_and_columns(C, A.rows(), B.rows());
  return refined(
      C,
      [&](const MatrixXd& right) -> MatrixXd {
        return (a.U * solve_product(a.T, b.T, a.U.adjoint() * right * b.U) * b.U.adjoint()).real();
      },
      [&](const MatrixXd& X) -> MatrixXd { return A * X * B.transpose() - X; });
}

MatrixXd continuous_lyapunov(const MatrixXd& A, const MatrixXd& C) {
  return symmetric(solve_sylvester(A, A.transpose(), -C));
}

MatrixXd discrete_lyapunov(const MatrixXd& A, const MatrixXd& C) {
  return symmetric(solve_stein(A, A, -C));
}

MatrixXd continuous_lyapunov(const MatrixXd& A, const MatrixXd& E, const MatrixXd& C) {
  const auto inverse = inverse_of(E, A);
  const MatrixXd ordinary = inverse.solve(A);
  return refined(
      -C,
      [&](const MatrixXd& right) -> MatrixXd {
        return continuous_lyapunov(ordinary, -inverse.solve(inverse.solve(right).transpose()));
      },
      [&](const MatrixXd& X) -> MatrixXd { return A * X * E.transpose() + E * X * A.transpose(); });
}

MatrixXd discrete_lyapunov(const MatrixXd& A, const MatrixXd& E, const MatrixXd& C) {
  const auto inverse = inverse_of(E, A);
  const MatrixXd ordinary = inverse.solve(A);
  return refined(
      -C,
      [&](const MatrixXd& right) -> MatrixXd {
        return discrete_lyapunov(ordinary, -inverse.solve(inverse.solve(right).transpose()));
      },
      [&](const MatrixXd& X) -> MatrixXd { return A * X * A.transpose() - E * X * E.transpose(); });
}

}  // namespace roadbalance
