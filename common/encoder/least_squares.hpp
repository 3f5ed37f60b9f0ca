#pragma once

#include <array>
#include <cmath>

namespace roadbalance {

/// Least-squares polynomial y(u) = sum c_k T_k(u), -1 <= u <= 1, with Chebyshev's T_k so that the normal
/// equations stay well conditioned.  No allocation; points are not kept.
template <int Order>
class LeastSquares {
 public:
  static constexpr int kTerms = Order + 1;
  using Terms = std::array<double, kTerms>;

  /// @param weight  1 / variance of y, in any unit
  void add(double u, double y, double weight = 1.0) noexcept {
    const Terms t = terms(u);
#pragma GCC unroll 8
    for (int i = 0; i < kTerms; ++i) {
      const double weighted = weight * t[at(i)];
#pragma GCC unroll 8
      for (int j = 0; j <= i; ++j) normal_[at(i)][at(j)] += weighted * t[at(j)];
      right_[at(i)] += weighted * y;
    }
  }

  /// False if the points do not determine the polynomial.
  [[nodiscard]] bool solve() noexcept {
    for (int i = 0; i < kTerms; ++i)  // Cholesky factor in place
      for (int j = 0; j <= i; ++j) {
        double sum = normal_[at(i)][at(j)];
        for (int k = 0; k < j; ++k) sum -= normal_[at(i)][at(k)] * normal_[at(j)][at(k)];
        if (i == j && !(sum > 1e-9)) return false;
        normal_[at(i)][at(j)] = i == j ? std::sqrt(sum) : sum / normal_[at(j)][at(j)];
      }
    coefficient_ = right_;
    for (int i = 0; i < kTerms; ++i) {
      for (int k = 0; k < i; ++k) coefficient_[at(i)] -= normal_[at(i)][at(k)] * coefficient_[at(k)];
      coefficient_[at(i)] /= normal_[at(i)][at(i)];
    }
    for (int i = kTerms - 1; i >= 0; --i) {
      for (int k = i + 1; k < kTerms; ++k) coefficient_[at(i)] -= normal_[at(k)][at(i)] * coefficient_[at(k)];
      coefficient_[at(i)] /= normal_[at(i)][at(i)];
    }
    return true;
  }

  /// Variance of value(u), in the unit in which the weights are its inverse.  After solve().
  double variance(double u) const noexcept {
    Terms t = terms(u);
    double sum = 0.0;
    for (int i = 0; i < kTerms; ++i) {
      for (int k = 0; k < i; ++k) t[at(i)] -= normal_[at(i)][at(k)] * t[at(k)];
      t[at(i)] /= normal_[at(i)][at(i)];
      sum += t[at(i)] * t[at(i)];
    }
    return sum;
  }

  double value(double u) const noexcept {
    const Terms t = terms(u);
    double sum = 0.0;
#pragma GCC unroll 8
    for (int i = 0; i < kTerms; ++i) sum += coefficient_[at(i)] * t[at(i)];
    return sum;
  }

  /// dy/du at u = 1, where that of T_k is k^2.
  double slope_at_end() const noexcept {
    double sum = 0.0;
    for (int i = 1; i < kTerms; ++i) sum += coefficient_[at(i)] * i * i;
    return sum;
  }

 private:
  static constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

  static Terms terms(double u) noexcept {
    Terms t{};
    t[0] = 1.0;
    if constexpr (Order >= 1) t[1] = u;
#pragma GCC unroll 8
    for (int i = 2; i < kTerms; ++i) t[at(i)] = 2.0 * u * t[at(i - 1)] - t[at(i - 2)];
    return t;
  }

  std::array<Terms, kTerms> normal_{};
  Terms right_{}, coefficient_{};
};

}  // namespace roadbalance
