#include "common/dsp/state_filter.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "common/dsp/lanes.hpp"

namespace roadbalance {
namespace {

struct Step {
  int order;
  Eigen::Index channels;
  const double *A, *b0, *b1, *x, *u;  ///< A [order x order], x [channels x order], by columns
  double *last, *next;
};

template <typename Vector>
inline constexpr int kLanesOf = sizeof(Vector) / sizeof(double);

// Vector by vector, so that each stays in a register.
template <int kVectors, typename Vector>
[[gnu::always_inline]] inline void load(Vector* values, const double* from) {
#pragma GCC unroll 4
  for (int v = 0; v < kVectors; ++v) std::memcpy(&values[v], from + v * kLanesOf<Vector>, sizeof(Vector));
}
template <int kVectors, typename Vector>
[[gnu::always_inline]] inline void store(const Vector* values, double* to) {
#pragma GCC unroll 4
  for (int v = 0; v < kVectors; ++v) std::memcpy(to + v * kLanesOf<Vector>, &values[v], sizeof(Vector));
}

/// Some vectors of channels from `first` on.  For an order that is known at compile time (0: that of the
/// step) each state is read once.
template <int kLanes, int kVectors, int kOrder>
[[gnu::always_inline]] inline void advance_channels(const Step& s, Eigen::Index first) {
  using Vector = typename Lanes<kLanes>::Vector;
  const int order = kOrder > 0 ? kOrder : s.order;
  Vector last[kVectors], u[kVectors], x[kOrder > 0 ? kOrder : 1][kVectors];
  load<kVectors>(last, s.last + first);
  load<kVectors>(u, s.u + first);
#pragma GCC unroll 8
  for (int j = 0; j < kOrder; ++j) load<kVectors>(x[j], s.x + first + j * s.channels);
#pragma GCC unroll 8
  for (int i = 0; i < order; ++i) {
    Vector sum[kVectors];
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) sum[v] = s.b0[i] * last[v] + s.b1[i] * u[v];
#pragma GCC unroll 8
    for (int j = 0; j < order; ++j) {
      if (kOrder == 0) load<kVectors>(x[0], s.x + first + j * s.channels);
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) sum[v] += s.A[i + j * order] * x[kOrder > 0 ? j : 0][v];
    }
    store<kVectors>(sum, s.next + first + i * s.channels);
  }
  store<kVectors>(u, s.last + first);
}

template <int kLanes, int kOrder>
[[gnu::always_inline]] inline void advance_all(const Step& s) {
  Eigen::Index c = 0;
  for (; c + 2 * kLanes <= s.channels; c += 2 * kLanes) advance_channels<kLanes, 2, kOrder>(s, c);
  for (; c + kLanes <= s.channels; c += kLanes) advance_channels<kLanes, 1, kOrder>(s, c);
  for (; c + 2 <= s.channels; c += 2) advance_channels<2, 1, kOrder>(s, c);
  for (; c < s.channels; ++c) advance_channels<1, 1, kOrder>(s, c);
}

/// The orders of our instruments and anti-aliasing filters are known to the compiler.
template <int kLanes>
[[gnu::always_inline]] inline void advance(const Step& s) {
  if (s.order == 5)
    advance_all<kLanes, 5>(s);
  else if (s.order == 6)
    advance_all<kLanes, 6>(s);
  else
    advance_all<kLanes, 0>(s);
}

RB_AVX512 void advance_avx512(const Step& s) {
  advance<8>(s);
}
RB_AVX2 void advance_avx2(const Step& s) {
  advance<4>(s);
}
void advance_plain(const Step& s) {
  advance<2>(s);
}

}  // namespace

StateFilter::StateFilter(DiscreteFilter filter, Eigen::Index channels)
    : filter_(std::move(filter)),
      x_(static_cast<std::size_t>(channels * filter_.b0.size())),
      next_(x_.size()),
      last_(static_cast<std::size_t>(channels)) {}

StateFilter::States StateFilter::update(const Eigen::Ref<const Eigen::ArrayXd>& u) {
  static const auto advance_by = for_this_processor(advance_avx512, advance_avx2, advance_plain);
  assert(u.size() == std::ssize(last_));
  advance_by({static_cast<int>(filter_.b0.size()), u.size(), filter_.A.data(), filter_.b0.data(),
              filter_.b1.data(), x_.data(), u.data(), last_.data(), next_.data()});
  x_.swap(next_);
  return states();
}

void StateFilter::reset() {
  std::ranges::fill(x_, 0.0);
  std::ranges::fill(last_, 0.0);
}

}  // namespace roadbalance
