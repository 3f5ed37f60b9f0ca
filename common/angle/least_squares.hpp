#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "common/dsp/lanes.hpp"

namespace roadbalance {

/// Least-squares polynomial y(u) = sum c_k T_k(u), -1 <= u <= 1, with Chebyshev's T_k so that the normal
/// equations stay well conditioned.  No allocation; points are not kept, only the sums of w T_k and w y T_k:
/// since T_i T_j = (T_(i+j) + T_|i-j|) / 2, these are the normal equations.
/// @tparam Points  double, or Lanes<2>::Vector to add and ask two points at once
template <int Order, typename Points = double>
class LeastSquares {
  static_assert(Order >= 1);

 public:
  static constexpr int kTerms = Order + 1;

  void add(Points u, Points y) noexcept { add(u, y, Points{} + 1.0); }
  /// @param weight  1 / variance of y, in any unit; 0 is no point
  void add(Points u, Points y, Points weight) noexcept {
    Points before = weight, term = weight * u;
    const Points twice = u + u;
    moment_[0] += before;
    right_[0] += before * y;
#pragma GCC unroll 16
    for (int k = 1; k < kMoments; ++k) {
      moment_[at(k)] += term;
      if (k < kTerms) right_[at(k)] += term * y;
      const Points next = twice * term - before;
      before = term;
      term = next;
    }
  }

  /// False if the points do not determine the polynomial.
  [[nodiscard]] bool solve() noexcept {
    for (int i = 0; i < kTerms; ++i)  // Cholesky
      for (int j = 0; j <= i; ++j) {
        double sum = 0.5 * (total(moment_[at(i + j)]) + total(moment_[at(i - j)]));
        for (int k = 0; k < j; ++k) sum -= factor_[at(i)][at(k)] * factor_[at(j)][at(k)];
        if (i == j && !(sum > 1e-9)) return false;
        factor_[at(i)][at(j)] = i == j ? std::sqrt(sum) : sum / factor_[at(j)][at(j)];
      }
    for (int i = 0; i < kTerms; ++i) {
      coefficient_[at(i)] = total(right_[at(i)]);
      for (int k = 0; k < i; ++k) coefficient_[at(i)] -= factor_[at(i)][at(k)] * coefficient_[at(k)];
      coefficient_[at(i)] /= factor_[at(i)][at(i)];
    }
    for (int i = kTerms - 1; i >= 0; --i) {
      for (int k = i + 1; k < kTerms; ++k) coefficient_[at(i)] -= factor_[at(k)][at(i)] * coefficient_[at(k)];
      coefficient_[at(i)] /= factor_[at(i)][at(i)];
    }
    return true;
  }

  /// Variance of value(u), in the unit in which the weights are its inverse.  After solve().
  double variance(double u) const noexcept {
    std::array<double, kTerms> t{1.0, u};
    for (int i = 2; i < kTerms; ++i) t[at(i)] = 2.0 * u * t[at(i - 1)] - t[at(i - 2)];
    double sum = 0.0;
    for (int i = 0; i < kTerms; ++i) {
      for (int k = 0; k < i; ++k) t[at(i)] -= factor_[at(i)][at(k)] * t[at(k)];
      t[at(i)] /= factor_[at(i)][at(i)];
      sum += t[at(i)] * t[at(i)];
    }
    return sum;
  }

  template <typename Places>
  Places value(Places u) const noexcept {
    const Places twice = u + u;
    Places after{}, sum = Places{} + coefficient_[at(Order)];  // Clenshaw's sum
#pragma GCC unroll 8
    for (int k = Order - 1; k >= 1; --k) {
      const Places next = coefficient_[at(k)] + twice * sum - after;
      after = sum;
      sum = next;
    }
    return coefficient_[0] + u * sum - after;
  }

  /// dy/du at u = 1, where that of T_k is k^2.
  double slope_at_end() const noexcept {
    double sum = 0.0;
    for (int i = 1; i < kTerms; ++i) sum += coefficient_[at(i)] * i * i;
    return sum;
  }

 private:
  static constexpr int kMoments = 2 * Order + 1;

  static constexpr std::size_t at(int i) {
    return static_cast<std::size_t>(i);
  }
  static double total(double sum) noexcept {
    return sum;
  }
  static double total(Lanes<2>::Vector sum) noexcept {
    return sum[0] + sum[1];
  }

  std::array<Points, kMoments> moment_{};
  std::array<Points, kTerms> right_{};
  std::array<std::array<double, kTerms>, kTerms> factor_{};
  std::array<double, kTerms> coefficient_{};
};

}  // namespace roadbalance
