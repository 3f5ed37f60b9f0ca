#pragma once

#include <Eigen/Core>

#include "common/dsp/linear_filter.hpp"

namespace roadbalance {

/// Adds to `sum` the products of two sets of signals at lags 0, 1, ...:
///
///     sum[:, k n .. k n + n - 1] += sum over t = 0 .. T - 1 of y(t) z(t + k)'
///
/// That is one matrix product of y and the block Hankel matrix of z, which is never made: its column t is
/// the n lags numbers from z(t) on, as they lie in memory.  In double; by AVX-512 or AVX2 where the processor
/// has them, chosen once at run time.  Never allocates.
///
/// @param y    [l x T], one sample a column
/// @param z    [n x at least T + lags - 1]
/// @param sum  [l x n lags]
/// @throws std::invalid_argument if the shapes do not fit
void add_lagged_products(const Eigen::Ref<const Eigen::MatrixXd>& y,
                         const Eigen::Ref<const Eigen::MatrixXd>& z, Eigen::Ref<Eigen::MatrixXd> sum);

/// The same of a filter's states y with y(t+1) = A y(t) + b0 u(t) + b1 u(t+1), for every lag but the last by
/// what the filter says of it.  Multiplied by z(t+1+k)' and summed over t,
///
///     C_k = A C_{k+1} + b0 R_{k+1} + b1 R_k + end terms,   R_k = sum u(t) z(t+k)',
///     end terms: b1 (u(T) z(T+k)' - u(0) z(k)') - (y(T) z(T+k)' - y(0) z(k)').
///
/// Only R and the last C are summed over time: for an order of 5 a quarter of the products.  Towards small
/// lags A damps rounding errors; towards large ones it would have to be inverted.
class LaggedCovariance {
 public:
  /// @param filter  of each input
  /// @param inputs, measured, lags  >= 1
  /// @throws std::invalid_argument
  LaggedCovariance(DiscreteFilter filter, Eigen::Index inputs, Eigen::Index measured, Eigen::Index lags);

  /// Takes further samples, without a hole.  Each column of u and y is one sample; of z there are lags - 1
  /// more, which the next call begins with.
  /// @param u  [inputs x T]
  /// @param y  [inputs order x T], state k of input i in row k inputs + i
  /// @param z  [measured x T + lags - 1]
  /// @throws std::invalid_argument if the shapes do not fit
  void add(const Eigen::Ref<const Eigen::MatrixXd>& u, const Eigen::Ref<const Eigen::MatrixXd>& y,
           const Eigen::Ref<const Eigen::MatrixXd>& z);

  /// [inputs order x measured lags] sums over all samples but the newest, which ends them; zero before there
  /// are two.
  Eigen::MatrixXd sums() const;

 private:
  DiscreteFilter filter_;
  Eigen::Index inputs_, measured_, lags_;
  Eigen::MatrixXd last_;       ///< C of the last lag
  Eigen::MatrixXd of_inputs_;  ///< R of all lags
  Eigen::MatrixXd u_, y_, z_;  ///< at the first sample and [right half] at the newest
  bool begun_ = false;
};

}  // namespace roadbalance
