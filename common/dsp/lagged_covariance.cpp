#include "common/dsp/lagged_covariance.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "common/dsp/lanes.hpp"

namespace roadbalance {
namespace {

constexpr Eigen::Index kMostSamples = 64;  ///< of a Product: they fit into the nearest cache

/// c[i + j c_stride] += sum over t of a[i + t a_stride] b[j + t b_stride]
struct Product {
  const double* a;
  Eigen::Index a_stride;
  const double* b;
  Eigen::Index b_stride;
  double* c;
  Eigen::Index c_stride;
  Eigen::Index rows, columns, samples;  ///< samples <= kMostSamples
};

/// A tile whose sums stay in registers while time runs.
template <int kLanes, int kVectors, int kColumns>
[[gnu::always_inline]] inline void tile(const Product& p, Eigen::Index column) {
  using Vector = typename Lanes<kLanes>::Vector;
  Vector sum[kVectors][kColumns] = {};
  const double* a = p.a;
  const double* b = p.b + column;
  double* const c = p.c + column * p.c_stride;
#pragma GCC unroll 16
  for (int j = 0; j < kColumns; ++j) __builtin_prefetch(c + j * p.c_stride, 1);
  for (Eigen::Index t = 0; t < p.samples; ++t, a += p.a_stride, b += p.b_stride) {
    Vector left[kVectors];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) std::memcpy(&left[v], a + v * kLanes, sizeof(Vector));
#pragma GCC unroll 16
    for (int j = 0; j < kColumns; ++j)
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) sum[v][j] += left[v] * b[j];
  }
#pragma GCC unroll 16
  for (int j = 0; j < kColumns; ++j)
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      double* const at = c + v * kLanes + j * p.c_stride;
      Vector old;
      std::memcpy(&old, at, sizeof old);
      old += sum[v][j];
      std::memcpy(at, &old, sizeof old);
    }
}

/// The first rows of the product, as many as vectors hold.
template <int kLanes, int kVectors, int kColumns>
[[gnu::always_inline]] inline void multiply_rows(const Product& p) {
  Eigen::Index column = 0;
  for (; column + kColumns <= p.columns; column += kColumns) tile<kLanes, kVectors, kColumns>(p, column);
  if constexpr (kColumns > 4)
    for (; column + 4 <= p.columns; column += 4) tile<kLanes, kVectors, 4>(p, column);
  for (; column < p.columns; ++column) tile<kLanes, kVectors, 1>(p, column);
}

/// Most rows are copied, so that those of a tile lie side by side on whole lines of the cache, and stay in
/// the nearest one, beside b, while all columns pass.
template <int kLanes, int kVectors, int kColumns>
[[gnu::always_inline]] inline void multiply(Product p) {
  constexpr Eigen::Index kRows = kVectors * kLanes;
  alignas(64) double copied[kMostSamples * kRows];
  const auto go_on = [&p](Eigen::Index rows) {
    p.a += rows;
    p.c += rows;
    p.rows -= rows;
  };
  for (; p.rows >= kRows; go_on(kRows)) {
    for (Eigen::Index t = 0; t < p.samples; ++t)
      std::memcpy(copied + t * kRows, p.a + t * p.a_stride, kRows * sizeof(double));
    Product of_copied = p;
    of_copied.a = copied;
    of_copied.a_stride = kRows;
    multiply_rows<kLanes, kVectors, kColumns>(of_copied);
  }
  for (; p.rows >= kLanes; go_on(kLanes)) multiply_rows<kLanes, 1, kColumns>(p);
  for (; p.rows > 0; go_on(1)) multiply_rows<1, 1, kColumns>(p);
}

// Sums fill the registers: 24 of 32, 12 of 16, 8 of 16.
RB_AVX512 void multiply_avx512(const Product& p) {
  multiply<8, 2, 12>(p);
}
RB_AVX2 void multiply_avx2(const Product& p) {
  multiply<4, 2, 6>(p);
}
void multiply_plain(const Product& p) {
  multiply<2, 2, 4>(p);
}

void check(bool fits, const char* what) {
  if (!fits) throw std::invalid_argument(what);
}

}  // namespace

void add_lagged_products(const Eigen::Ref<const Eigen::MatrixXd>& y,
                         const Eigen::Ref<const Eigen::MatrixXd>& z, Eigen::Ref<Eigen::MatrixXd> sum) {
  static const auto multiply_by = for_this_processor(multiply_avx512, multiply_avx2, multiply_plain);
  const Eigen::Index n = z.rows(), samples = y.cols();
  check(sum.rows() == y.rows(), "sums of lagged products need a row for each first signal");
  check(n > 0 && sum.cols() % n == 0 && sum.cols() > 0, "sums of lagged products need columns of whole lags");
  check(z.cols() >= samples + sum.cols() / n - 1, "lagged products need samples up to the last lag");
  check(z.outerStride() == n || sum.cols() == n, "lagged products need samples one behind the other");
  for (Eigen::Index t = 0; t < samples; t += kMostSamples)
    multiply_by({y.data() + t * y.outerStride(), y.outerStride(), z.data() + t * z.outerStride(),
                 z.outerStride(), sum.data(), sum.outerStride(), y.rows(), sum.cols(),
                 std::min(kMostSamples, samples - t)});
}

LaggedCovariance::LaggedCovariance(DiscreteFilter filter, Eigen::Index inputs, Eigen::Index measured,
                                   Eigen::Index lags)
    : filter_(std::move(filter)), inputs_(inputs), measured_(measured), lags_(lags) {
  check(inputs > 0 && measured > 0 && lags > 0, "lagged covariances need inputs, measurements and a lag");
  const Eigen::Index states = filter_.b0.size() * inputs;
  last_ = Eigen::MatrixXd::Zero(states, measured);
  of_inputs_ = Eigen::MatrixXd::Zero(inputs, measured * lags);
  u_ = Eigen::MatrixXd::Zero(inputs, 2);
  y_ = Eigen::MatrixXd::Zero(states, 2);
  z_ = Eigen::MatrixXd::Zero(measured * lags, 2);
}

void LaggedCovariance::add(const Eigen::Ref<const Eigen::MatrixXd>& u,
                           const Eigen::Ref<const Eigen::MatrixXd>& y,
                           const Eigen::Ref<const Eigen::MatrixXd>& z) {
  const Eigen::Index T = u.cols();
  check(u.rows() == inputs_ && y.rows() == y_.rows() && y.cols() == T && z.rows() == measured_ &&
            z.cols() == T + lags_ - 1 && z.outerStride() == measured_,
        "samples of lagged covariances have another shape");
  if (T == 0) return;
  const auto keep = [&](Eigen::Index t, Eigen::Index place) {
    u_.col(place) = u.col(t);
    y_.col(place) = y.col(t);
    z_.col(place) = Eigen::Map<const Eigen::VectorXd>(z.data() + t * measured_, measured_ * lags_);
  };
  if (!std::exchange(begun_, true)) keep(0, 0);
  add_lagged_products(y, z.rightCols(T), last_);
  add_lagged_products(u, z, of_inputs_);
  keep(T - 1, 1);
}

Eigen::MatrixXd LaggedCovariance::sums() const {
  // The newest sample's products are in the sums, and end them: they are taken out again.
  const auto of_newest = [&](const Eigen::MatrixXd& first, Eigen::Index k) -> Eigen::MatrixXd {
    return first.col(1) * z_.col(1).segment(k * measured_, measured_).transpose();
  };
  const auto of_first = [&](const Eigen::MatrixXd& first, Eigen::Index k) -> Eigen::MatrixXd {
    return first.col(0) * z_.col(0).segment(k * measured_, measured_).transpose();
  };
  const auto R = [&](Eigen::Index k) -> Eigen::MatrixXd {
    return of_inputs_.middleCols(k * measured_, measured_) - of_newest(u_, k);
  };
  Eigen::MatrixXd C(y_.rows(), measured_ * lags_);
  C.rightCols(measured_) = last_ - of_newest(y_, lags_ - 1);
  for (Eigen::Index k = lags_ - 2; k >= 0; --k) {
    const Eigen::MatrixXd before = R(k + 1), now = R(k) + of_newest(u_, k) - of_first(u_, k);
    const Eigen::MatrixXd ends = of_newest(y_, k) - of_first(y_, k);
    const auto later = C.middleCols((k + 1) * measured_, measured_);
    for (Eigen::Index i = 0; i < filter_.b0.size(); ++i) {
      auto here = C.block(i * inputs_, k * measured_, inputs_, measured_);
      here = filter_.b0(i) * before + filter_.b1(i) * now - ends.middleRows(i * inputs_, inputs_);
      for (Eigen::Index j = 0; j < filter_.b0.size(); ++j)
        here += filter_.A(i, j) * later.middleRows(j * inputs_, inputs_);
    }
  }
  return C;
}

}  // namespace roadbalance
