#include "common/dsp/transfer_function.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace roadbalance {

TransferFunction transfer_function(std::span<const double> input, std::span<const double> output,
                                   std::span<const std::complex<double>> cross, double independent_averages) {
  const std::size_t bins = cross.size();
  if (input.size() != bins || output.size() != bins)
    throw std::invalid_argument("spectra of a transfer function differ in length");
  constexpr double kOutside = 0.05;
  const double n = independent_averages;
  const bool scatters = n > 1.0;
  // F of 2 and 2 (n - 1) degrees of freedom has this quantile in closed form, over n - 1.
  const double quantile = scatters ? std::pow(kOutside, -1.0 / (n - 1.0)) - 1.0 : 0.0;

  TransferFunction result;
  result.h1.resize(bins), result.h2.resize(bins), result.hv.resize(bins);
  result.coherence.resize(bins), result.coherence_sigma.resize(bins);
  result.radius_95.assign(bins, std::numeric_limits<double>::infinity());
  if (scatters) result.coherence_by_chance = 1.0 - std::pow(kOutside, 1.0 / (n - 1.0));
  for (std::size_t k = 0; k < bins; ++k) {
    const double power = input[k] * output[k], common = std::norm(cross[k]);
    if (!(power > 0.0)) continue;
    const double coherence = std::min(1.0, common / power);
    result.coherence[k] = coherence;
    result.h1[k] = cross[k] / input[k];
    if (common > 0.0) {
      result.h2[k] = output[k] / std::conj(cross[k]);
      result.hv[k] = std::polar(std::sqrt(output[k] / input[k]), std::arg(cross[k]));
    }
    if (!scatters) continue;
    result.coherence_sigma[k] = std::sqrt(2.0 * coherence / n) * (1.0 - coherence);
    result.radius_95[k] = std::sqrt(quantile * (1.0 - coherence) * output[k] / input[k]);
  }
  return result;
}

std::optional<double> mean_delay_s(const TransferFunction& h, double step_hz) {
  constexpr double kLeastIncoherence =
      1e-3;  // no phase is known better than that: noise of the converter is in both
  std::complex<double> turn = 0.0;
  for (std::size_t k = 1; k + 1 < h.h1.size(); ++k) {  // not at 0 Hz, where there is no phase
    const double least = std::min(h.coherence[k], h.coherence[k + 1]);
    const double size = std::abs(h.h1[k]) * std::abs(h.h1[k + 1]);
    if (!(least > h.coherence_by_chance) || size == 0.0) continue;
    turn += least / std::max(1.0 - least, kLeastIncoherence) * (h.h1[k + 1] * std::conj(h.h1[k])) / size;
  }
  if (turn == 0.0) return std::nullopt;
  return -std::arg(turn) / (2.0 * std::numbers::pi * step_hz);
}

}  // namespace roadbalance
