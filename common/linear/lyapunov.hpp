#pragma once

#include <Eigen/Core>

namespace roadbalance {

/// Linear matrix equations by the complex Schur form, each with one step of refinement; O(n^3).
///
/// Bartels and Stewart: with A = U T U^H and B = V R V^H (T, R upper triangular) the columns of the turned
/// equation follow from one another, each a triangular system.
///
/// All throw std::invalid_argument for shapes that do not fit, std::domain_error where there is no unique
/// solution (to within rounding).
///
/// Source: R. H. Bartels, G. W. Stewart, Solution of the matrix equation AX + XB = C, CACM 15 (1972) 820;
/// descriptor forms as in T. Penzl, Numerical solution of generalized Lyapunov equations, Adv. Comput. Math.
/// 8 (1998) 33.

/// Solves A X + X B = C.  No eigenvalue of A may be that of -B.
/// @param A  [m x m]
/// @param B  [n x n]
/// @param C  [m x n]
Eigen::MatrixXd solve_sylvester(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::MatrixXd& C);

/// Solves A X B' - X = C.  No product of an eigenvalue of A with one of B may be 1.
Eigen::MatrixXd solve_stein(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::MatrixXd& C);

/// Solves A X + X A' = -C with symmetric C: the covariance X of x' = A x + w, E[w w'] = C delta, if A is
/// stable.
Eigen::MatrixXd continuous_lyapunov(const Eigen::MatrixXd& A, const Eigen::MatrixXd& C);
/// Solves A X A' - X = -C with symmetric C: the covariance of x[k+1] = A x[k] + w[k], E[w w'] = C.
Eigen::MatrixXd discrete_lyapunov(const Eigen::MatrixXd& A, const Eigen::MatrixXd& C);

/// The same for systems in descriptor form with regular E, as mechanical ones come:
/// A X E' + E X A' = -C, the covariance of E x' = A x + w.
Eigen::MatrixXd continuous_lyapunov(const Eigen::MatrixXd& A, const Eigen::MatrixXd& E,
                                    const Eigen::MatrixXd& C);
/// A X A' - E X E' = -C, the covariance of E x[k+1] = A x[k] + w[k].
Eigen::MatrixXd discrete_lyapunov(const Eigen::MatrixXd& A, const Eigen::MatrixXd& E,
                                  const Eigen::MatrixXd& C);

}  // namespace roadbalance
