#include "common/dsp/fractional_delay.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "common/dsp/lanes.hpp"

namespace roadbalance {
namespace {

constexpr double kBeta = 10.0;

double kaiser_sinc(double at) {
  const double position = at / (0.5 * FractionalDelay::kTaps);
  if (std::abs(position) >= 1.0) return 0.0;
  const double window = std::cyl_bessel_i(0.0, kBeta * std::sqrt(1.0 - position * position));
  const double x = std::numbers::pi * at;
  return window * (std::abs(x) < 1e-9 ? 1.0 : std::sin(x) / x);
}

/// Between two columns of the table, which lie one behind the other.
template <int kLanes>
[[gnu::always_inline]] inline void mix(const double* below, double part, double* taps) {
  using Vector = typename Lanes<kLanes>::Vector;
  const double other_part = 1.0 - part;
#pragma GCC unroll 16
  for (int k = 0; k < FractionalDelay::kTaps; k += kLanes) {
    Vector a, b;
    std::memcpy(&a, below + k, sizeof a);
    std::memcpy(&b, below + FractionalDelay::kTaps + k, sizeof b);
    const Vector sum = other_part * a + part * b;
    std::memcpy(taps + k, &sum, sizeof sum);
  }
}
RB_AVX512 void mix_avx512(const double* below, double part, double* taps) {
  mix<8>(below, part, taps);
}
RB_AVX2 void mix_avx2(const double* below, double part, double* taps) {
  mix<4>(below, part, taps);
}
void mix_plain(const double* below, double part, double* taps) {
  mix<2>(below, part, taps);
}

}  // namespace

const FractionalDelay::Table& FractionalDelay::table() {
  static const Table all = [] {
    Table table;
    for (int f = 0; f <= kFractions; ++f) {
      const double fraction = static_cast<double>(f) / kFractions;
      for (int k = 0; k < kTaps; ++k) table(k, f) = kaiser_sinc(k - kBefore - fraction);
      table.col(f) /= table.col(f).sum();
    }
    return table;
  }();
  return all;
}

FractionalDelay::Taps FractionalDelay::taps(double fraction) const {
  static const auto mix_by = for_this_processor(mix_avx512, mix_avx2, mix_plain);
  const double place = std::clamp(fraction, 0.0, 1.0) * kFractions;
  const int below = std::min(static_cast<int>(place), kFractions - 1);
  Taps taps;
  mix_by(table_->col(below).data(), place - below, taps.data());
  return taps;
}

}  // namespace roadbalance
