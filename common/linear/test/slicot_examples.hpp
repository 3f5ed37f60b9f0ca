#pragma once

// Input and printed results of the example programs of SLICOT, files examples/data/*.dat and
// examples/results/*.res of https://github.com/SLICOT/SLICOT-Reference, under the BSD 3-clause licence of
// slicot_license.txt beside this file.

#include <Eigen/Core>

namespace roadbalance::test::slicot {

/// Four digits behind the point are printed, 1.86155 as 1.8616.  The estimates that the programs print beside
/// the solutions (separation, condition, error bound) are of SLICOT's own way and not here.
inline constexpr double kPrinted = 0.5e-4 * (1.0 + 1e-6);

inline Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index columns,
                              std::initializer_list<double> entries) {
  Eigen::MatrixXd result(rows, columns);
  auto entry = entries.begin();
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j < columns; ++j) result(i, j) = *entry++;
  return result;
}

/// SB03MD (discrete), SB03QD (continuous) and SB03SD (discrete) have these in common.
inline const Eigen::MatrixXd kA = matrix(3, 3, {3, 1, 1, 1, 3, 0, 0, 0, 3});
inline const Eigen::MatrixXd kC = matrix(3, 3, {25, 24, 15, 24, 32, 8, 15, 8, 40});
/// SB03MD and SB03SD: A' X A - X = C.
inline const Eigen::MatrixXd kSb03mdX = matrix(3, 3, {2, 1, 1, 1, 3, 0, 1, 0, 4});
/// SB03QD: A' X + X A = C.
inline const Eigen::MatrixXd kSb03qdX =
    matrix(3, 3, {3.2604, 2.7187, 1.8616, 2.7187, 4.4271, 0.5699, 1.8616, 0.5699, 6.0461});

/// SB03OD: A' X + X A = -B' B, X = U' U.
inline const Eigen::MatrixXd kSb03odA =
    matrix(4, 4, {-1, 37, -12, -12, -1, -10, 0, 4, 2, -4, 7, -6, 2, 2, 7, -9});
inline const Eigen::MatrixXd kSb03odB =
    matrix(5, 4, {1, 2.5, 1, 3.5, 0, 1, 0, 1, -1, -2.5, -1, -1.5, 1, 2.5, 4, -5.5, -1, -2.5, -4, 3.5});
inline const Eigen::MatrixXd kSb03odUTransposed =
    matrix(4, 4, {1, 0, 0, 0, 3, 1, 0, 0, 2, -1, 1, 0, -1, 1, -2, 1});
inline const Eigen::MatrixXd kSb03odX = matrix(4, 4, {1, 3, 2, -1, 3, 10, 5, -2, 2, 5, 6, -5, -1, -2, -5, 7});

/// SG03AD: A' X E + E' X A = Y.
inline const Eigen::MatrixXd kSg03adA = matrix(3, 3, {3, 1, 1, 1, 3, 0, 1, 0, 2});
inline const Eigen::MatrixXd kSg03adE = matrix(3, 3, {1, 3, 0, 3, 2, 1, 1, 0, 1});
inline const Eigen::MatrixXd kSg03adY = matrix(3, 3, {-64, -73, -28, -73, -70, -25, -28, -25, -18});
inline const Eigen::MatrixXd kSg03adX = matrix(3, 3, {-2, -1, 0, -1, -3, -1, 0, -1, -3});

/// SG03BD: A' X E + E' X A = -B' B, X = U' U.
inline const Eigen::MatrixXd kSg03bdA = matrix(3, 3, {-1, 3, -4, 0, 5, -2, -4, 4, 1});
inline const Eigen::MatrixXd kSg03bdE = matrix(3, 3, {2, 1, 3, 2, 0, 1, 4, 5, 1});
inline const Eigen::MatrixXd kSg03bdB = matrix(1, 3, {2, -1, 7});
inline const Eigen::MatrixXd kSg03bdU =
    matrix(3, 3, {1.6003, -0.4418, -0.1523, 0, 0.6795, -0.2499, 0, 0, 0.2041});

}  // namespace roadbalance::test::slicot
