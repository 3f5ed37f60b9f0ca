#include "host/analysis/calibration/channel_match.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <utility>

namespace roadbalance {
namespace {

/// Hann makes neighbouring bins alike by 2/3 and the next by 1/6: their products scatter as so many fewer.
constexpr double kBinsShared = 1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0);
constexpr double kNoSignal = 1e-3;  ///< of the strongest bin's amplitude; there is nothing to compare

double coherence(const Eigen::MatrixXcd& s, int a, int b) {
  const double power = s(a, a).real() * s(b, b).real();
  return power > 0.0 ? std::min(1.0 - 1e-9, std::norm(s(a, b)) / power) : 0.0;
}

/// Bins of the band in which there is a signal at all: it is in two channels at least.
std::vector<std::size_t> bins_with_signal(const BandSpectra& spectra) {
  std::vector<double> level(spectra.matrix.size());
  for (std::size_t k = 0; k < level.size(); ++k) {
    Eigen::VectorXd power = spectra.matrix[k].diagonal().real();
    std::sort(power.begin(), power.end());
    level[k] = power(power.size() - 2);
  }
  const double strongest = *std::ranges::max_element(level);
  std::vector<std::size_t> bins;
  for (std::size_t k = 0; k < level.size(); ++k)
    if (strongest > 0.0 && level[k] >= kNoSignal * kNoSignal * strongest) bins.push_back(k);
  return bins;
}

double mean_coherence(const BandSpectra& spectra, const std::vector<std::size_t>& bins, int a, int b) {
  double sum = 0.0;
  for (const std::size_t k : bins) sum += coherence(spectra.matrix[k], a, b);
  return bins.empty() ? 0.0 : sum / static_cast<double>(bins.size());
}

/// The channel whose coherence with the others is best in the median.
int pilot_of(const BandSpectra& spectra, const std::vector<std::size_t>& bins, int channels) {
  int best = 0;
  double most = -1.0;
  for (int a = 0; a < channels; ++a) {
    std::vector<double> with;
    for (int b = 0; b < channels; ++b)
      if (b != a) with.push_back(mean_coherence(spectra, bins, a, b));
    std::ranges::sort(with);
    const double median = with[with.size() / 2];
    if (median > most) most = median, best = a;
  }
  return best;
}

std::complex<double> over_pilot(const Eigen::MatrixXcd& s, int k, int p, const std::vector<int>& others) {
  std::complex<double> sum = 0.0;
  double power = 0.0;
  for (const int m : others) {
    if (m == k || m == p) continue;
    sum += s(m, k) * std::conj(s(m, p));
    power += std::norm(s(m, p));
  }
  return power > 0.0 ? sum / power : s(p, k) / s(p, p);
}

ChannelMatch compare(const BandSpectra& spectra, const std::vector<std::size_t>& bins, int k, int p,
                     const std::vector<int>& coherent) {
  ChannelMatch match;
  match.coherence = mean_coherence(spectra, bins, k, p);
  struct Point {
    double omega, weight;
    std::complex<double> h;
  };
  std::vector<Point> points;
  std::complex<double> mean = 0.0;
  for (const std::size_t bin : bins) {
    const double g2 = coherence(spectra.matrix[bin], k, p);
    if (g2 < kLeastCoherence) continue;
    const double weight = 2.0 * spectra.independent_averages * g2 / (1.0 - g2);
    points.push_back({2.0 * std::numbers::pi * spectra.frequency_hz[bin], weight,
                      over_pilot(spectra.matrix[bin], k, p, coherent)});
    mean += weight * points.back().h;
  }
  if (points.empty() || static_cast<double>(points.size()) < kLeastShare * static_cast<double>(bins.size()))
    return match;
  const double sign = mean.real() < 0.0 ? -1.0 : 1.0;
  double weights = 0.0, gains = 0.0, slope = 0.0, squares = 0.0, misfit = 0.0;
  for (const Point& point : points) {
    weights += point.weight;
    gains += point.weight * std::abs(point.h);
    slope -= point.weight * point.omega * std::arg(sign * point.h);
    squares += point.weight * point.omega * point.omega;
  }
  match.gain = gains / weights;
  match.gain_sigma = match.gain * std::sqrt(kBinsShared / weights);
  match.delay_s = slope / squares;
  match.delay_sigma_s = std::sqrt(kBinsShared / squares);
  for (const Point& point : points)
    misfit += point.weight * std::pow(std::arg(sign * point.h) + point.omega * match.delay_s, 2);
  match.misfit_rad = std::sqrt(misfit / weights);
  const double scatter_rad = std::sqrt(static_cast<double>(points.size()) / weights);
  match.verdict = sign < 0.0                                               ? ChannelMatch::Verdict::kInverted
                  : match.misfit_rad > kMostMisfit_rad + 3.0 * scatter_rad ? ChannelMatch::Verdict::kNoDelay
                                                                           : ChannelMatch::Verdict::kMatched;
  return match;
}

/// Variances of pairs with the pilot -> of each channel alone: the pilot's noise is half of what it has
/// together with the best of the others.
void share_with_pilot(std::vector<ChannelMatch>& all, int pilot, double ChannelMatch::*sigma) {
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < std::ssize(all); ++k)
    if (const ChannelMatch& one = all[static_cast<std::size_t>(k)]; k != pilot && one.*sigma > 0.0)
      least = std::min(least, one.*sigma * (one.*sigma));
  if (!std::isfinite(least)) return;
  for (int k = 0; k < std::ssize(all); ++k) {
    double& own = all[static_cast<std::size_t>(k)].*sigma;
    own = k == pilot ? std::sqrt(least / 2.0) : std::sqrt(std::max(0.0, own * own - least / 2.0));
  }
}

/// From relative to the pilot to relative to the median of the reference: one channel that is off must not
/// put all others off.
bool refer_to(const std::vector<int>& reference, std::vector<ChannelMatch>& all) {
  std::vector<double> gains, delays;
  double gain_variance = 0.0, delay_variance = 0.0;
  std::vector<bool> counts(all.size());
  for (const int r : reference) {
    const ChannelMatch& one = all[static_cast<std::size_t>(r)];
    if (one.verdict != ChannelMatch::Verdict::kMatched) continue;
    counts[static_cast<std::size_t>(r)] = true;
    gains.push_back(one.gain);
    delays.push_back(one.delay_s);
    gain_variance += one.gain_sigma * one.gain_sigma;
    delay_variance += one.delay_sigma_s * one.delay_sigma_s;
  }
  if (gains.empty()) return false;
  const double gain = median(gains), delay_s = median(delays);
  const auto count = static_cast<double>(gains.size());
  // A median of many scatters by that much more than a mean.
  const double cost = count > 2.0 ? std::numbers::pi / 2.0 : 1.0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    ChannelMatch& one = all[k];
    // Its own noise is in the median, too.
    const double rest = counts[k] ? 1.0 - 2.0 / count : 1.0;
    const auto sigma = [&](double own, double sum) {
      return std::sqrt(std::max(0.0, own * own * rest + cost * sum / (count * count)));
    };
    one.gain_sigma = sigma(one.gain_sigma, gain_variance) / gain;
    one.gain /= gain;
    one.delay_sigma_s = sigma(one.delay_sigma_s, delay_variance);
    one.delay_s -= delay_s;
  }
  return true;
}

}  // namespace

BandSpectra spectra_in_band(const CrossSpectra& spectra, double low_hz, double high_hz) {
  BandSpectra band{{}, {}, spectra.averages(), spectra.independent_averages()};
  for (int k = 0; k < spectra.bins(); ++k) {
    const double frequency_hz = k * spectra.step_hz();
    if (frequency_hz < low_hz || frequency_hz > high_hz) continue;
    band.frequency_hz.push_back(frequency_hz);
    band.matrix.push_back(spectra.matrix(k));
  }
  return band;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

ChannelMatches match_channels(const BandSpectra& spectra, const std::vector<int>& reference) {
  using Reason = ChannelMatches::Reason;
  if (spectra.averages < kLeastAverages) return {Reason::kTooShort};
  if (spectra.matrix.empty()) return {Reason::kNoTwoAlike};
  const auto channels = static_cast<int>(spectra.matrix.front().rows());
  if (channels < 2) return {Reason::kNoTwoAlike};
  const auto bins = bins_with_signal(spectra);
  if (bins.empty()) return {Reason::kNoTwoAlike};
  const int pilot = pilot_of(spectra, bins, channels);
  std::vector<int> coherent;
  for (int k = 0; k < channels; ++k)
    if (mean_coherence(spectra, bins, k, pilot) >= kLeastCoherence) coherent.push_back(k);
  if (coherent.size() < 2) return {Reason::kNoTwoAlike};
  std::vector<ChannelMatch> all;
  for (int k = 0; k < channels; ++k) all.push_back(compare(spectra, bins, k, pilot, coherent));
  share_with_pilot(all, pilot, &ChannelMatch::gain_sigma);
  share_with_pilot(all, pilot, &ChannelMatch::delay_sigma_s);
  if (!refer_to(reference, all)) return {Reason::kReference};
  return {Reason::kNone, std::move(all)};
}

}  // namespace roadbalance
