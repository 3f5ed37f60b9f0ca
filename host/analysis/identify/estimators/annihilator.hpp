#pragma once

#include <Eigen/Core>

#include "common/dsp/linear_filter.hpp"

namespace roadbalance {

/// Rows H that make instruments of the states y of a linear filter y' = F y + G x:
///
///     H [F^-1 G, F^-2 G] = 0.
///
/// w = H F^-2 y then has the derivatives w' = H F^-1 y and w'' = H y, whatever x is: only where G enters
/// would x itself occur, and there H is zero.  Filters of several signals are blocks of one diagonal F, and H
/// has the same blocks; this is one block.
struct Annihilator {
  Eigen::MatrixXd w2;  ///< H       [order - 2 x order]
  Eigen::MatrixXd w1;  ///< H F^-1
  Eigen::MatrixXd w0;  ///< H F^-2

  Eigen::Index instruments() const { return w2.rows(); }
};

/// For any filter with a regular F: an orthonormal basis of the left null space of [F^-1 G, F^-2 G], by SVD.
/// @throws std::invalid_argument if the order is below 3: nothing is annihilated
Annihilator annihilator(const ContinuousFilter& filter);

/// For a filter in companion form scaled by its corner wc (butterworth()): H drops the first two states, so
/// instrument j = 0 .. order - 3 is (w, w', w'') = (y_j / wc^2, y_(j+1) / wc, y_(j+2)).
/// @throws as annihilator()
Annihilator companion_annihilator(const ContinuousFilter& filter);

}  // namespace roadbalance
