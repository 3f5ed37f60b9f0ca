#include "common/dsp/decimating_filter.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <utility>

#include "common/dsp/lanes.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kTogether = 4;  // samples
constexpr std::size_t kLine = kCacheLine / sizeof(double);

struct Spread {
  std::size_t rows, stride;    ///< channels; from one sample, or output, to the next
  std::size_t outputs, first;  ///< first: of sums, what weight begins with
  const double *samples, *weight;
  double* sums;  ///< [row x output]
};

/// Some rows of samples in a row, to outputs in a row.  Sums are read and written once for all the samples.
template <int kSamples, typename Vector>
[[gnu::always_inline]] inline void spread_to(const Vector* x, const Spread& s, const double* weight,
                                             double* sum, const double* end) {
  const std::size_t stride = s.stride, outputs = s.outputs;
  for (; sum != end; sum += stride, ++weight) {
    Vector y;
    std::memcpy(&y, sum, sizeof y);
#pragma GCC unroll 4
    for (std::size_t k = 0; k < kSamples; ++k) y += weight[k * outputs] * x[k];
    std::memcpy(sum, &y, sizeof y);
  }
}

template <int kSamples, int kLanes>
[[gnu::always_inline]] inline void spread_rows(const Spread& s, std::size_t row) {
  typename Lanes<kLanes>::Vector x[kSamples];
#pragma GCC unroll 4
  for (std::size_t k = 0; k < kSamples; ++k) std::memcpy(&x[k], s.samples + k * s.stride + row, sizeof x[k]);
  double *const begin = s.sums + row, *const first = begin + s.first * s.stride;
  spread_to<kSamples>(x, s, s.weight, first, begin + s.outputs * s.stride);
  spread_to<kSamples>(x, s, s.weight + s.outputs - s.first, begin, first);
}

template <int kSamples, int kLanes>
[[gnu::always_inline]] inline void spread_samples(const Spread& s) {
  std::size_t r = 0;
  if constexpr (kLanes >= 8)
    for (; r + 8 <= s.rows; r += 8) spread_rows<kSamples, 8>(s, r);
  if constexpr (kLanes >= 4)
    for (; r + 4 <= s.rows; r += 4) spread_rows<kSamples, 4>(s, r);
  for (; r + 2 <= s.rows; r += 2) spread_rows<kSamples, 2>(s, r);
  for (; r < s.rows; ++r) spread_rows<kSamples, 1>(s, r);
}

template <int kLanes>
[[gnu::always_inline]] inline void spread(const Spread& s, std::size_t samples) {
  if (samples == kTogether) return spread_samples<kTogether, kLanes>(s);
  Spread one = s;
  for (std::size_t k = 0; k < samples; ++k) {
    spread_samples<1, kLanes>(one);
    one.samples += s.stride;
    one.weight += s.outputs;
  }
}

RB_AVX512 void spread_avx512(const Spread& s, std::size_t samples) {
  spread<8>(s, samples);
}
RB_AVX2 void spread_avx2(const Spread& s, std::size_t samples) {
  spread<4>(s, samples);
}
void spread_plain(const Spread& s, std::size_t samples) {
  spread<2>(s, samples);
}

/// Column by column of the samples from behind an output through the next one.
Eigen::MatrixXd weights(int factor, const Eigen::VectorXd& taps) {
  const Eigen::Index last = taps.size() - 1;
  Eigen::MatrixXd weight(last / factor + 1, factor);
  for (Eigen::Index place = 0; place < factor; ++place)
    for (Eigen::Index k = 0; k < weight.rows(); ++k) {
      const Eigen::Index behind = factor - 1 - place + k * factor;  // the sample, until the output
      weight(k, place) = behind <= last ? taps(last - behind) : 0.0;
    }
  return weight;
}

}  // namespace

DecimatingFilter::DecimatingFilter(Eigen::Index channels, int factor, const Eigen::VectorXd& taps)
    : taps_(taps.size()),
      weight_(weights(factor, taps)),
      stride_((static_cast<std::size_t>(channels) + kLine - 1) / kLine * kLine),
      waiting_(stride_ * kTogether),
      sums_(stride_ * static_cast<std::size_t>(weight_.rows())),
      output_(channels) {
  restart(0);
}

void DecimatingFilter::restart(std::int64_t index) {
  std::ranges::fill(sums_, 0.0);
  const Eigen::Index factor = weight_.cols();
  place_ = ((index - 1) % factor + factor) % factor;
  known_ = 0;
  samples_ = 0;
}

bool DecimatingFilter::add(const Eigen::Ref<const Eigen::VectorXd>& values) {
  assert(values.size() == output_.size());
  std::copy_n(values.data(), values.size(), waiting_.data() + samples_++ * stride_);
  if (known_ < taps_) ++known_;
  const bool is_complete = ++place_ == weight_.cols();
  if (is_complete || samples_ == kTogether) spread();
  if (!is_complete) return false;
  place_ = 0;
  double* const sum = sums_.data() + next_ * stride_;
  std::copy_n(sum, output_.size(), output_.data());
  std::fill_n(sum, stride_, 0.0);
  if (++next_ == static_cast<std::size_t>(weight_.rows())) next_ = 0;
  return known_ == taps_;
}

/// The waiting samples, to the sums.
void DecimatingFilter::spread() {
  static const auto spread_by = for_this_processor(spread_avx512, spread_avx2, spread_plain);
  const Eigen::Index first = place_ - static_cast<Eigen::Index>(samples_);
  spread_by({static_cast<std::size_t>(output_.size()), stride_, static_cast<std::size_t>(weight_.rows()),
             next_, waiting_.data(), weight_.col(first).data(), sums_.data()},
            std::exchange(samples_, 0));
}

}  // namespace roadbalance
