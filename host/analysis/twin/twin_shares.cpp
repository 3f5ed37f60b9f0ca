#include "host/analysis/twin/twin_shares.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace roadbalance {
namespace {

constexpr double kSegment_s = 2.0;
constexpr double kBand_rad_s = 2.0 * std::numbers::pi * (kHopHigh_hz - kHopLow_hz);
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Butterworth's low-pass of second order, s -> (s^2 + w0^2) / (B s): B^2 s^2 over this.
ContinuousFilter band_pass() {
  const double w2 = 4.0 * std::numbers::pi * std::numbers::pi * kHopLow_hz * kHopHigh_hz, B = kBand_rad_s;
  Eigen::VectorXd d(4);
  d << w2 * w2, std::numbers::sqrt2 * B * w2, 2.0 * w2 + B * B, std::numbers::sqrt2 * B;
  return companion(d);
}

int segment_of(double rate_hz) {
  return static_cast<int>(std::lround(kSegment_s * rate_hz));
}

TwinFigures figures(const auto& squares, int first, double count) {
  return {std::sqrt(squares(first) / count), std::sqrt(squares(first + 1) / count),
          std::sqrt(squares(first + 2) / count)};
}

}  // namespace

double TwinFigures::share() const {
  return measured > 0.0 ? 1.0 - residual * residual / (measured * measured) : kNone;
}

TwinShares::TwinShares(const TwinChannels& channels, double rate_hz, double memory_s)
    : channels_(channels),
      samples_(static_cast<int>(std::lround(rate_hz))),
      step_ns_(1e9 / rate_hz),
      band_(discretise_ramp_invariant(band_pass(), 1.0 / rate_hz),
            2 * static_cast<Eigen::Index>(channels.channel.size())),
      band_gain_(kBand_rad_s * kBand_rad_s),
      // Segments overlap by half: two a segment's length.
      spectra_({.welch = {.rate_hz = rate_hz, .segment = segment_of(rate_hz)},
                .channels = 2 * static_cast<int>(channels.channel.size()),
                .memory = static_cast<int>(std::lround(2.0 * memory_s / kSegment_s))}) {
  const auto n = static_cast<Eigen::Index>(channels.channel.size());
  spectra_in_.setZero(2 * n, samples_);
  both_.setZero(2 * n);
  now_ = squares_of(n);
  all_ = squares_of(n);
  seconds_.assign(channels.channel.size(), 0);
  state_.assign(channels.channel.size(), TwinState::kSettling);
  second_.channel.resize(channels.channel.size());
  begin_second();
}

void TwinShares::begin_second() {
  filled_ = 0;
  speed_sum_ = 0.0;
  now_.setZero();
  std::ranges::fill(state_, TwinState::kPredicted);
}

const TwinSecond* TwinShares::add(const TwinSample& sample) {
  if (last_ns_ != 0 && std::abs(static_cast<double>(sample.time_ns - last_ns_) - step_ns_) > 0.5 * step_ns_) {
    begin_second();  // a hole: what there was of this second is no second
    band_.reset();
    spectra_.gap();
  }
  last_ns_ = sample.time_ns;
  add_squares(sample);
  add_trace(sample);
  speed_sum_ += sample.speed_m_s;
  if (++filled_ < samples_) return nullptr;
  end_second();
  begin_second();
  return &second_;
}

void TwinShares::add_squares(const TwinSample& sample) {
  const Eigen::Index n = now_.rows();
  both_.head(n) = sample.measured.array();
  both_.tail(n) = sample.predicted.array();
  const auto band = band_.update(both_).col(2) * band_gain_;  // state 2 is s^2 / D(s)
  now_.col(0) += both_.head(n).square();
  now_.col(1) += both_.tail(n).square();
  now_.col(2) += (both_.head(n) - both_.tail(n)).square();
  now_.col(3) += band.head(n).square();
  now_.col(4) += band.tail(n).square();
  now_.col(5) += (band.head(n) - band.tail(n)).square();
  for (Eigen::Index c = 0; c < n; ++c) {
    const auto part = static_cast<std::size_t>(channels_.channel[static_cast<std::size_t>(c)].part);
    const TwinState state = sample.state[part];
    // A sample that is not predicted is silent on both sides and adds nothing to any density.
    const double used = state == TwinState::kPredicted ? 1.0 : 0.0;
    spectra_in_(c, filled_) = used * both_(c);
    spectra_in_(n + c, filled_) = used * both_(n + c);
    if (state != TwinState::kPredicted) state_[static_cast<std::size_t>(c)] = state;
  }
}

void TwinShares::add_trace(const TwinSample& sample) {
  const auto point = [&](int k) { return static_cast<std::size_t>(k * kTracePoints / samples_); };
  const std::size_t at = point(filled_);
  int neighbours = 1;
  const int first = filled_ == 0 || point(filled_ - 1) != at;
  for (int k = filled_ - 1; k >= 0 && point(k) == at; --k) ++neighbours;
  for (std::size_t c = 0; c < second_.channel.size(); ++c) {
    const auto take = [&](float& mean, double value) {
      mean = first ? static_cast<float>(value)
                   : mean + (static_cast<float>(value) - mean) / static_cast<float>(neighbours);
    };
    take(second_.channel[c].measured[at], sample.measured(static_cast<Eigen::Index>(c)));
    take(second_.channel[c].predicted[at], sample.predicted(static_cast<Eigen::Index>(c)));
  }
}

void TwinShares::end_second() {
  spectra_.add(spectra_in_);
  second_.time_ns = last_ns_;
  second_.speed_m_s = speed_sum_ / samples_;
  std::vector<TwinAccount*> accounts;
  for (std::size_t c = 0; c < seconds_.size(); ++c) {
    TwinAccount& account = second_.channel[c].account;
    account.state = state_[c];
    const auto row = now_.row(static_cast<Eigen::Index>(c));
    account.all = figures(row, 0, samples_);
    account.hop = figures(row, 3, samples_);
    accounts.push_back(&account);
    if (state_[c] != TwinState::kPredicted) continue;
    all_.row(static_cast<Eigen::Index>(c)) += row;
    ++seconds_[c];
  }
  put_coherent(accounts);
}

void TwinShares::put_coherent(std::vector<TwinAccount*>& accounts) const {
  const int n = static_cast<int>(accounts.size());
  for (int c = 0; c < n; ++c) {
    const auto cross = spectra_.density(c, n + c);
    const auto measured = spectra_.density(c), predicted = spectra_.density(n + c);
    std::array<double, 2> coherent{}, sum{};  // all, the band
    for (std::size_t k = 1; k < cross.size(); ++k) {
      const double f_hz = static_cast<double>(k) * spectra_.step_hz();
      const double both = predicted[k] > 0.0 ? std::norm(cross[k]) / predicted[k] : 0.0;
      const bool in_band = kHopLow_hz <= f_hz && f_hz <= kHopHigh_hz;
      for (std::size_t which = 0; which < (in_band ? 2U : 1U); ++which) {
        coherent[which] += both;
        sum[which] += measured[k];
      }
    }
    TwinAccount& account = *accounts[static_cast<std::size_t>(c)];
    account.coherent_all = sum[0] > 0.0 ? coherent[0] / sum[0] : kNone;
    account.coherent_hop = sum[1] > 0.0 ? coherent[1] / sum[1] : kNone;
  }
}

std::vector<TwinAccount> TwinShares::total() const {
  std::vector<TwinAccount> total(seconds_.size());
  std::vector<TwinAccount*> accounts;
  for (std::size_t c = 0; c < total.size(); ++c) {
    total[c].state = seconds_[c] > 0 ? TwinState::kPredicted : second_.channel[c].account.state;
    const auto row = all_.row(static_cast<Eigen::Index>(c));
    const double count = static_cast<double>(std::max(1, seconds_[c])) * samples_;
    total[c].all = figures(row, 0, count);
    total[c].hop = figures(row, 3, count);
    accounts.push_back(&total[c]);
  }
  put_coherent(accounts);
  return total;
}

}  // namespace roadbalance
