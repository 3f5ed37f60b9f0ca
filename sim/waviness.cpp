#include "sim/waviness.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace roadbalance::sim {
namespace {

constexpr double kLowest_1_m = 0.003, kHighest_1_m = 30.0;

/// log |F| of sharp bends, but for a constant.
double log_wanted(const Waviness& waviness, double wave_number_1_m) {
  const double bend_1_m = waviness.bend_1_m > 0.0 ? waviness.bend_1_m : kHighest_1_m;
  return (1.0 - 0.5 * waviness.below) * std::log(std::min(wave_number_1_m, bend_1_m)) +
         (1.0 - 0.5 * waviness.above) * std::log(std::max(wave_number_1_m, bend_1_m) / bend_1_m);
}

}  // namespace

void WavinessFilter::set(const Waviness& waviness, double gain) {
  is_flat_ = waviness.is_two();
  gain_ = gain;
  if (is_flat_) return;
  const double decades = std::log(kHighest_1_m / kLowest_1_m);
  for (int k = 0; k < kSections; ++k) {
    const double centre_1_m = kLowest_1_m * std::exp(decades * (k + 0.5) / kSections);
    // |F| ~ n^a over the section's part of the band; the bend's section has both exponents, each by its
    // share.
    const double width = decades / kSections;
    const double bend =
        waviness.bend_1_m > 0.0 ? std::log(waviness.bend_1_m / centre_1_m) / width + 0.5 : 1.0;
    const double below = std::clamp(bend, 0.0, 1.0);
    const double a = 1.0 - 0.5 * (below * waviness.below + (1.0 - below) * waviness.above);
    const double apart = std::exp(0.5 * a * decades / kSections);
    // (1 + s / zero) / (1 + s / pole), s = 2 / h (z - 1) / (z + 1)
    const double half_m = 2.0 / grid_m_;
    const double zero = half_m / (2.0 * std::numbers::pi * centre_1_m / apart);
    const double pole = half_m / (2.0 * std::numbers::pi * centre_1_m * apart);
    Section& section = section_[static_cast<std::size_t>(k)];
    section.now = (1.0 + zero) / (1.0 + pole);
    section.before = (1.0 - zero) / (1.0 + pole);
    section.keep = -(1.0 - pole) / (1.0 + pole);
  }
  // The bend is round: the level is that of a place away from it.
  const bool is_near =
      waviness.bend_1_m > 0.0 && std::abs(std::log(kReferenceWaveNumber_1_m / waviness.bend_1_m)) < 1.1;
  const double level_1_m = is_near ? 10.0 * waviness.bend_1_m : kReferenceWaveNumber_1_m;
  const double wanted =
      std::exp(log_wanted(waviness, level_1_m) - log_wanted(waviness, kReferenceWaveNumber_1_m));
  gain_ = 1.0;
  gain_ = gain * wanted / magnitude(level_1_m);
}

Eigen::Vector2d WavinessFilter::filter(Eigen::Vector2d noise) {
  if (is_flat_) return gain_ * noise;
  for (Section& s : section_) {
    s.last_out = (s.now * noise + s.before * s.last_in + s.keep * s.last_out).eval();
    s.last_in = noise;
    noise = s.last_out;
  }
  return gain_ * noise;
}

double WavinessFilter::magnitude(double wave_number_1_m) const {
  if (is_flat_) return gain_;
  const std::complex<double> back = std::polar(1.0, -2.0 * std::numbers::pi * wave_number_1_m * grid_m_);
  double magnitude = gain_;
  for (const Section& s : section_) magnitude *= std::abs((s.now + s.before * back) / (1.0 - s.keep * back));
  return magnitude;
}

}  // namespace roadbalance::sim
