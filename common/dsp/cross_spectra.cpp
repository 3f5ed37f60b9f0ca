#include "common/dsp/cross_spectra.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace roadbalance {
namespace {

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

/// Data a multiple of a large power of two apart need the same lines of a cache.
constexpr std::size_t odd(std::size_t lanes) {
  return lanes | 1U;
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
      history_(settings.channels, settings.welch.segment),
      column_(odd(static_cast<std::size_t>(settings.welch.segment) / kLane + 1)),
      columns_(static_cast<std::size_t>(std::min(kAtOnce, settings.channels)) * column_),
      line_(2 * odd(static_cast<std::size_t>(tiles_))),
      segment_(static_cast<std::size_t>(settings.channels) * line_),
      batch_(kBatch * segment_),
      sum_(static_cast<std::size_t>(tiles_) * static_cast<std::size_t>(pairs_) * 2) {
  for (auto k = static_cast<std::size_t>(hop_); k < window_.size(); k += static_cast<std::size_t>(hop_))
    overlap_.push_back(correlation(window_, k));
  recent_.resize(overlap_.size());
  lagged_.resize(overlap_.size() + 1);
  if (settings.hold_peaks)
    peak_.resize(static_cast<std::size_t>(tiles_) * static_cast<std::size_t>(settings.channels));
}

std::size_t CrossSpectra::bytes(int channels, int segment) {
  const auto n = static_cast<std::size_t>(channels), samples = static_cast<std::size_t>(segment);
  const std::size_t bins = samples / 2 + kLane, pairs = n * (n + 1) / 2;
  return sizeof(double) * (2 * bins * (pairs + kBatch * n) + samples * (n + kAtOnce + 4));
}

void CrossSpectra::add(const Eigen::Ref<const Eigen::MatrixXd>& samples) {
  if (samples.rows() != settings_.channels)
    throw std::invalid_argument("spectra of " + std::to_string(settings_.channels) + " channels got " +
                                std::to_string(samples.rows()));
  for (Eigen::Index taken = 0; taken < samples.cols();) {
    const Eigen::Index n = std::min({samples.cols() - taken, fft_.size() - filled_, history_.cols() - next_});
    if (samples.outerStride() == samples.rows())
      std::memcpy(history_.col(next_).data(), samples.col(taken).data(),
                  static_cast<std::size_t>(n * samples.rows()) * sizeof(double));
    else
      history_.middleCols(next_, n) = samples.middleCols(taken, n);
    next_ = (next_ + n) % history_.cols();
    filled_ += n;
    taken += n;
    if (filled_ == fft_.size()) add_segment();
  }
}

void CrossSpectra::add_segment() {
  const auto channels = static_cast<std::size_t>(settings_.channels),
             samples = static_cast<std::size_t>(fft_.size());
  const std::size_t older = samples - static_cast<std::size_t>(next_);  // than where the ring begins
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(settings_.channels);
  if (settings_.remove_means) mean = history_.rowwise().mean();
  for (std::size_t first = 0; first < channels; first += kAtOnce) {
    const std::size_t end = std::min(channels, first + kAtOnce);
    Tapering part{.in = history_.col(next_).data(),
                  .channels = channels,
                  .first = first,
                  .end = end,
                  .window = window_.data(),
                  .samples = older,
                  .mean = mean.data(),
                  .out = columns_.front().of,
                  .column = column_ * kLane};
    taper_columns(part);
    part.in = history_.data();
    part.window += older;
    part.samples = samples - older;
    part.out += older;
    taper_columns(part);
    for (std::size_t c = first; c < end; ++c)
      fft_.transform({columns_[(c - first) * column_].of, samples},
                     {&batch_[static_cast<std::size_t>(waiting_) * segment_ + c * line_], line_});
  }
  ++averages_;
  ++waiting_;
  weigh_newest();
  filled_ = fft_.size() - hop_;
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
  for (int tile = 0; tile < tiles_; ++tile) {
    const Lane* const lines = &batch_[2 * static_cast<std::size_t>(tile)];
    TileSums work{lines,
                  line_,
                  segment_,
                  &sum_[place(tile, 0, 0)],
                  before,
                  {},
                  static_cast<std::size_t>(settings_.channels)};
    std::copy(weight.begin(), weight.end(), work.weight);
    sum_up_tile(work);
    if (settings_.hold_peaks) hold_peaks(tile, lines);
  }
  waiting_ = 0;
}

void CrossSpectra::hold_peaks(int tile, const Lane* lines) const {
  const auto channels = static_cast<std::size_t>(settings_.channels);
  for (std::size_t a = 0; a < channels; ++a) {
    Lane& peak = peak_[static_cast<std::size_t>(tile) * channels + a];
    for (int s = 0; s < waiting_; ++s) {
      const Lane* const line = lines + static_cast<std::size_t>(s) * segment_ + a * line_;
      for (int k = 0; k < kLane; ++k)
        peak.of[k] = std::max(peak.of[k], line[0].of[k] * line[0].of[k] + line[1].of[k] * line[1].of[k]);
    }
  }
}

void CrossSpectra::reset() {
  filled_ = 0;
  waiting_ = averages_ = summed_ = 0;
  std::fill(recent_.begin(), recent_.end(), 0.0);
  std::fill(lagged_.begin(), lagged_.end(), 0.0);
  std::fill(sum_.begin(), sum_.end(), Lane());
  std::fill(peak_.begin(), peak_.end(), Lane());
  std::fill(batch_.begin(), batch_.end(), Lane());  // what weighs nothing is added, too
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
    const std::complex<double> mean(sum_[at].of[k % kLane], sum_[at + 1].of[k % kLane]);
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
      G(a, b) = one_sided(bin) * std::complex<double>(sum_[at].of[bin % kLane], sum_[at + 1].of[bin % kLane]);
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
    result[static_cast<std::size_t>(k)] = one_sided(k) * peak_[at].of[k % kLane];
  }
  return result;
}

}  // namespace roadbalance
