#include "common/dsp/window.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace roadbalance {
namespace {

std::vector<double> cosine_terms(Window kind) {
  switch (kind) {
    case Window::kRectangular:
      return {1.0};
    case Window::kHann:
      return {0.5, 0.5};
    case Window::kFlatTop:
      return {1.0, 1.9383379, 1.3045202, 0.4028270, 0.0350665};
  }
  throw std::invalid_argument("no such window");
}

}  // namespace

std::vector<double> window(Window kind, int size) {
  if (size < 1) throw std::invalid_argument("window size must be at least 1");
  const auto a = cosine_terms(kind);
  std::vector<double> w(static_cast<std::size_t>(size), 0.0);
  for (std::size_t n = 0; n < w.size(); ++n) {
    const double turn = 2.0 * std::numbers::pi * static_cast<double>(n) / size;
    for (std::size_t k = 0; k < a.size(); ++k)
      w[n] += (k % 2 == 0 ? a[k] : -a[k]) * std::cos(static_cast<double>(k) * turn);
  }
  return w;
}

double equivalent_noise_bandwidth_bins(std::span<const double> window) {
  double sum = 0.0;
  double squares = 0.0;
  for (const double w : window) {
    sum += w;
    squares += w * w;
  }
  return static_cast<double>(window.size()) * squares / (sum * sum);
}

}  // namespace roadbalance
