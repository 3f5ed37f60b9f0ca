#include "common/dsp/cross_spectra.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "common/dsp/lanes.hpp"

namespace roadbalance {
namespace {

constexpr int kBins = 8, kSegments = 8;  // of a tile and of a batch

/// One tile: its pairs' sums, weighed by `before`, take up the segments that wait, each with its weight.
struct Tile {
  const double* lines;  ///< [segment][channel][re, im][bin], `row` from one segment to the next
  double* sum;          ///< [pair][re, im][bin]
  double before;
  double weight[kSegments];  ///< 0 where none waits
  std::size_t channels;
  std::size_t row;
};

/// kLanes of the tile's bins, from `bin` on.
template <int kLanes>
[[gnu::always_inline]] inline void sum_up_bins(const Tile& tile, int bin) {
  using Vector = typename Lanes<kLanes>::Vector;
  const std::size_t row = tile.row;
  double* sum = tile.sum + bin;
  for (std::size_t a = 0; a < tile.channels; ++a) {
    const double* const own = tile.lines + a * 2 * kBins + bin;
    Vector re[kSegments], im[kSegments];
#pragma GCC unroll 8
    for (int s = 0; s < kSegments; ++s) {
      std::memcpy(&re[s], own + static_cast<std::size_t>(s) * row, sizeof(Vector));
      std::memcpy(&im[s], own + static_cast<std::size_t>(s) * row + kBins, sizeof(Vector));
      re[s] *= tile.weight[s];
      im[s] *= tile.weight[s];
    }
    const double* other = own;
    for (std::size_t b = a; b < tile.channels; ++b, other += 2 * kBins, sum += 2 * kBins) {
      // Two sums each, so that an addition need not wait for the one before it.
      Vector real, imaginary, real2 = {}, imaginary2 = {};
      std::memcpy(&real, sum, sizeof real);
      std::memcpy(&imaginary, sum + kBins, sizeof imaginary);
      real *= tile.before;
      imaginary *= tile.before;
#pragma GCC unroll 8
      for (int s = 0; s < kSegments; ++s) {
        Vector x, y;
        std::memcpy(&x, other + static_cast<std::size_t>(s) * row, sizeof x);
        std::memcpy(&y, other + static_cast<std::size_t>(s) * row + kBins, sizeof y);
        real += re[s] * x;
        real2 += im[s] * y;
        imaginary += re[s] * y;
        imaginary2 -= im[s] * x;
      }
      real += real2;
      imaginary += imaginary2;
      std::memcpy(sum, &real, sizeof real);
      std::memcpy(sum + kBins, &imaginary, sizeof imaginary);
    }
  }
}

template <int kLanes>
[[gnu::always_inline]] inline void sum_up_tile(const Tile& tile) {
  for (int bin = 0; bin < kBins; bin += kLanes) sum_up_bins<kLanes>(tile, bin);
}

RB_AVX512 void sum_up_avx512(const Tile& tile) {
  sum_up_tile<8>(tile);
}
RB_AVX2 void sum_up_avx2(const Tile& tile) {
  sum_up_tile<4>(tile);
}
void sum_up_plain(const Tile& tile) {
  sum_up_tile<2>(tile);
}

const CrossSpectra::Settings& checked(const CrossSpectra::Settings& settings) {
  const auto& welch = settings.welch;
  if (!(welch.rate_hz > 0.0)) throw std::invalid_argument("sampling rate of spectra must be positive");
  if (welch.segment < 2) throw std::invalid_argument("segment of spectra must have at least 2 samples");
  if (!(welch.overlap >= 0.0 && welch.overlap < 1.0))
    throw std::invalid_argument("overlap of spectra must be 0 <= overlap < 1");
  if (settings.channels < 1) throw std::invalid_argument("spectra need a channel");
  if (settings.memory < 0)
    throw std::invalid_argument("memory of an exponential average must not be negative");
  return settings;
}

/// Squared correlation of the spectra of two segments, one `shift` samples after the other, of white noise.
double correlation(const std::vector<double>& window, std::size_t shift) {
  const auto later = window.begin() + static_cast<std::ptrdiff_t>(shift);
  const double common = std::inner_product(later, window.end(), window.begin(), 0.0);
  return std::pow(common / std::inner_product(window.begin(), window.end(), window.begin(), 0.0), 2);
}

}  // namespace

CrossSpectra::CrossSpectra(const Settings& settings)
    : settings_(checked(settings)),
      fft_(settings.welch.segment),
      window_(window(settings.welch.window, settings.welch.segment)),
      hop_(std::max<Eigen::Index>(1, std::lround((1.0 - settings.welch.overlap) * settings.welch.segment))),
      tiles_((fft_.bins() + kLane - 1) / kLane),
      pairs_(settings.channels * (settings.channels + 1) / 2),
      step_hz_(settings.welch.rate_hz / settings.welch.segment),
      enbw_hz_(equivalent_noise_bandwidth_bins(window_) * step_hz_),
      scale_(1.0 / (settings.welch.rate_hz *
                    std::inner_product(window_.begin(), window_.end(), window_.begin(), 0.0))),
      history_(Eigen::MatrixXd::Zero(settings.welch.segment + kLane, settings.channels)),
      segment_(static_cast<std::size_t>(tiles_) * static_cast<std::size_t>(settings.channels) * 2 + 1),
      batch_(kBatch * segment_, Lane::Zero()),
      sum_(static_cast<std::size_t>(tiles_) * static_cast<std::size_t>(pairs_) * 2, Lane::Zero()) {
  for (auto k = static_cast<std::size_t>(hop_); k < window_.size(); k += static_cast<std::size_t>(hop_))
    overlap_.push_back(correlation(window_, k));
  recent_.resize(overlap_.size());
  lagged_.resize(overlap_.size() + 1);
  if (settings.hold_peaks)
    peak_.assign(static_cast<std::size_t>(tiles_) * static_cast<std::size_t>(settings.channels),
                 Lane::Zero());
}

std::size_t CrossSpectra::bytes(int channels, int segment) {
  const auto n = static_cast<std::size_t>(channels), samples = static_cast<std::size_t>(segment);
  const std::size_t bins = samples / 2 + kLane, pairs = n * (n + 1) / 2;
  return sizeof(double) * (2 * bins * (pairs + kBatch * n) + samples * (n + 4));
}

void CrossSpectra::add(const Eigen::Ref<const Eigen::MatrixXd>& samples) {
  if (samples.rows() != settings_.channels)
    throw std::invalid_argument("spectra of " + std::to_string(settings_.channels) + " channels got " +
                                std::to_string(samples.rows()));
  for (Eigen::Index taken = 0; taken < samples.cols();) {
    const Eigen::Index n = std::min(samples.cols() - taken, fft_.size() - filled_);
    history_.middleRows(filled_, n) = samples.middleCols(taken, n).transpose();
    filled_ += n;
    taken += n;
    if (filled_ == fft_.size()) add_segment();
  }
}

void CrossSpectra::add_segment() {
  const auto channels = static_cast<std::size_t>(settings_.channels);
  const Eigen::Map<const Eigen::ArrayXd> taper(window_.data(), fft_.size());
  for (std::size_t c = 0; c < channels; ++c) {
    const auto samples = history_.col(static_cast<Eigen::Index>(c)).head(fft_.size()).array();
    const double mean = settings_.remove_means ? samples.mean() : 0.0;
    Eigen::Map<Eigen::ArrayXd>(fft_.input().data(), fft_.size()) = taper * (samples - mean);
    const std::span<const std::complex<double>> lines = fft_.transform();
    Lane* lane = &batch_[static_cast<std::size_t>(waiting_) * segment_ + 2 * c];
    for (std::size_t first = 0; first < lines.size(); first += kLane, lane += 2 * channels) {
      double* const re = lane[0].data();
      double* const im = lane[1].data();
      const std::size_t count = std::min<std::size_t>(kLane, lines.size() - first);
      for (std::size_t k = 0; k < count; ++k) {
        re[k] = lines[first + k].real();
        im[k] = lines[first + k].imag();
      }
    }
  }
  ++averages_;
  ++waiting_;
  weigh_newest();
  const Eigen::Index kept = fft_.size() - hop_;
  for (Eigen::Index c = 0; c < history_.cols(); ++c)
    std::memmove(history_.col(c).data(), history_.col(c).data() + hop_,
                 static_cast<std::size_t>(kept) * sizeof(double));
  filled_ = kept;
  if (waiting_ == kBatch) sum_up();
}

std::size_t CrossSpectra::place(int tile, int a, int b) const {
  // Rows of the upper triangle one after the other.
  const int pair = a * settings_.channels - a * (a - 1) / 2 + (b - a);
  return 2 *
         (static_cast<std::size_t>(tile) * static_cast<std::size_t>(pairs_) + static_cast<std::size_t>(pair));
}

void CrossSpectra::sum_up() const {
  if (waiting_ == 0) return;
  // The mean after segment m is (1 - 1/m) times the mean before it and 1/m of it; m stops at the memory.
  std::array<double, kBatch> weight{};
  double before = 1.0;
  for (int s = 0; s < waiting_; ++s) {
    const int m = ++summed_;
    const double share = 1.0 / (settings_.memory > 0 ? std::min(m, settings_.memory) : m);
    for (int earlier = 0; earlier < s; ++earlier) weight[static_cast<std::size_t>(earlier)] *= 1.0 - share;
    weight[static_cast<std::size_t>(s)] = share;
    before *= 1.0 - share;
  }
  static_assert(kLane == kBins && kBatch == kSegments && sizeof(Lane) == kBins * sizeof(double));
  static const auto sum_up_by = for_this_processor(sum_up_avx512, sum_up_avx2, sum_up_plain);
  const auto channels = static_cast<std::size_t>(settings_.channels);
  for (int tile = 0; tile < tiles_; ++tile) {
    const Lane* const lines = &batch_[2 * static_cast<std::size_t>(tile) * channels];
    Tile work{lines->data(), sum_[place(tile, 0, 0)].data(), before, {}, channels, segment_ * kLane};
    std::copy(weight.begin(), weight.end(), work.weight);
    sum_up_by(work);
    if (settings_.hold_peaks) hold_peaks(tile, lines);
  }
  waiting_ = 0;
}

void CrossSpectra::hold_peaks(int tile, const Lane* lines) const {
  const auto channels = static_cast<std::size_t>(settings_.channels);
  for (std::size_t a = 0; a < channels; ++a) {
    Lane& peak = peak_[static_cast<std::size_t>(tile) * channels + a];
    for (int s = 0; s < waiting_; ++s) {
      const Lane* const line = lines + static_cast<std::size_t>(s) * segment_ + 2 * a;
      peak = peak.max(line[0].square() + line[1].square());
    }
  }
}

void CrossSpectra::reset() {
  filled_ = 0;
  waiting_ = averages_ = summed_ = 0;
  std::fill(recent_.begin(), recent_.end(), 0.0);
  std::fill(lagged_.begin(), lagged_.end(), 0.0);
  std::fill(sum_.begin(), sum_.end(), Lane::Zero());
  std::fill(peak_.begin(), peak_.end(), Lane::Zero());
  std::fill(batch_.begin(), batch_.end(), Lane::Zero());  // what weighs nothing is added, too
}

/// The newest segment has its share, those before it what is left.
void CrossSpectra::weigh_newest() {
  const double share = 1.0 / (settings_.memory > 0 ? std::min(averages_, settings_.memory) : averages_);
  for (double& weight : recent_) weight *= 1.0 - share;
  for (double& sum : lagged_) sum *= (1.0 - share) * (1.0 - share);
  lagged_[0] += share * share;
  for (std::size_t k = 0; k < recent_.size(); ++k) lagged_[k + 1] += share * recent_[k];
  if (recent_.empty()) return;
  std::rotate(recent_.begin(), recent_.end() - 1, recent_.end());
  recent_.front() = share;
}

double CrossSpectra::independent_averages() const {
  if (averages_ == 0) return 0.0;
  double variance = lagged_[0];  // of the average, over that of one segment
  for (std::size_t k = 0; k < overlap_.size(); ++k) variance += 2.0 * overlap_[k] * lagged_[k + 1];
  return 1.0 / variance;
}

double CrossSpectra::one_sided(int bin) const {
  const bool alone = bin == 0 || 2 * bin == settings_.welch.segment;  // its own mirror image
  return (alone ? 1.0 : 2.0) * scale_;
}

std::vector<std::complex<double>> CrossSpectra::density(int a, int b) const {
  sum_up();
  std::vector<std::complex<double>> result(static_cast<std::size_t>(bins()));
  for (int k = 0; k < bins(); ++k) {
    const std::size_t at = place(k / kLane, std::min(a, b), std::max(a, b));
    const std::complex<double> mean(sum_[at](k % kLane), sum_[at + 1](k % kLane));
    result[static_cast<std::size_t>(k)] = one_sided(k) * (a <= b ? mean : std::conj(mean));
  }
  return result;
}

std::vector<double> CrossSpectra::density(int a) const {
  const auto with_itself = density(a, a);
  std::vector<double> result(with_itself.size());
  std::transform(with_itself.begin(), with_itself.end(), result.begin(), [](auto g) { return g.real(); });
  return result;
}

Eigen::MatrixXcd CrossSpectra::matrix(int bin) const {
  sum_up();
  Eigen::MatrixXcd G(settings_.channels, settings_.channels);
  for (int a = 0; a < settings_.channels; ++a)
    for (int b = a; b < settings_.channels; ++b) {
      const std::size_t at = place(bin / kLane, a, b);
      G(a, b) = one_sided(bin) * std::complex<double>(sum_[at](bin % kLane), sum_[at + 1](bin % kLane));
      G(b, a) = std::conj(G(a, b));
    }
  return G;
}

std::vector<double> CrossSpectra::peak_density(int a) const {
  sum_up();
  std::vector<double> result(static_cast<std::size_t>(bins()));
  if (peak_.empty()) return result;
  for (int k = 0; k < bins(); ++k) {
    const auto at = static_cast<std::size_t>(k / kLane) * static_cast<std::size_t>(settings_.channels) +
                    static_cast<std::size_t>(a);
    result[static_cast<std::size_t>(k)] = one_sided(k) * peak_[at](k % kLane);
  }
  return result;
}

}  // namespace roadbalance
