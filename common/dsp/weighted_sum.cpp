#include "common/dsp/weighted_sum.hpp"

#include <cassert>
#include <cstddef>
#include <cstring>

#include "common/dsp/lanes.hpp"

namespace roadbalance {
namespace {

struct Sum {
  const double* weight;
  std::size_t weights;
  const double* columns;
  std::size_t stride, rows;  ///< from one column to the next; of one
  double* sum;
};

/// Rows from `first` on.  Four sums each, so that an addition need not wait for the one before it.
template <int kLanes>
[[gnu::always_inline]] inline void sum_rows(const Sum& s, std::size_t first) {
  using Vector = typename Lanes<kLanes>::Vector;
  constexpr std::size_t kSums = 4;
  Vector part[kSums] = {};
  std::size_t k = 0;
  for (; k + kSums <= s.weights; k += kSums)
#pragma GCC unroll 4
    for (std::size_t i = 0; i < kSums; ++i) {
      Vector x;
      std::memcpy(&x, s.columns + (k + i) * s.stride + first, sizeof x);
      part[i] += s.weight[k + i] * x;
    }
  for (; k < s.weights; ++k) {
    Vector x;
    std::memcpy(&x, s.columns + k * s.stride + first, sizeof x);
    part[0] += s.weight[k] * x;
  }
  const Vector all = (part[0] + part[1]) + (part[2] + part[3]);
  std::memcpy(s.sum + first, &all, sizeof all);
}

template <int kLanes>
[[gnu::always_inline]] inline void sum_all(const Sum& s) {
  std::size_t r = 0;
  if constexpr (kLanes >= 8)
    for (; r + 8 <= s.rows; r += 8) sum_rows<8>(s, r);
  if constexpr (kLanes >= 4)
    for (; r + 4 <= s.rows; r += 4) sum_rows<4>(s, r);
  for (; r + 2 <= s.rows; r += 2) sum_rows<2>(s, r);
  for (; r < s.rows; ++r) sum_rows<1>(s, r);
}

RB_AVX512 void sum_avx512(const Sum& s) {
  sum_all<8>(s);
}
RB_AVX2 void sum_avx2(const Sum& s) {
  sum_all<4>(s);
}
void sum_plain(const Sum& s) {
  sum_all<2>(s);
}

}  // namespace

void weighted_sum(const Eigen::Ref<const Eigen::MatrixXd>& columns,
                  const Eigen::Ref<const Eigen::VectorXd>& weight, Eigen::Ref<Eigen::VectorXd> sum) {
  static const auto sum_by = for_this_processor(sum_avx512, sum_avx2, sum_plain);
  assert(columns.cols() == weight.size() && columns.rows() == sum.size());
  sum_by({weight.data(), static_cast<std::size_t>(weight.size()), columns.data(),
          static_cast<std::size_t>(columns.outerStride()), static_cast<std::size_t>(sum.size()), sum.data()});
}

}  // namespace roadbalance
