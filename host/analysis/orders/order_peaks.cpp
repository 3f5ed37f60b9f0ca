#include "host/analysis/orders/order_peaks.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {
namespace {

constexpr std::size_t kWidth = 5;  // of the flat top, in lines to either side

double median_around(const std::vector<double>& lines, std::size_t k, std::size_t reach) {
  const auto first = lines.begin() + static_cast<std::ptrdiff_t>(k > reach ? k - reach : 0);
  const auto last = lines.begin() + static_cast<std::ptrdiff_t>(std::min(lines.size(), k + reach + 1));
  std::vector<double> around(first, last);
  const auto middle = around.begin() + std::ssize(around) / 2;
  std::nth_element(around.begin(), middle, around.end());
  return *middle;
}

/// The least of the lines next to the window's width, to the side that `step` points to.
double valley(const std::vector<double>& lines, std::size_t k, int step) {
  double least = lines[k];
  for (std::size_t off = kWidth + 1; off <= kWidth + kPeakValley; ++off) {
    const auto i = static_cast<std::ptrdiff_t>(k) + step * static_cast<std::ptrdiff_t>(off);
    if (0 <= i && i < std::ssize(lines)) least = std::min(least, lines[static_cast<std::size_t>(i)]);
  }
  return least;
}

double centre(const std::vector<double>& lines, std::size_t k) {
  double sum = 0.0, moment = 0.0;
  for (std::size_t i = k - kWidth; i <= k + kWidth; ++i) {
    const double power = lines[i] * lines[i];
    sum += power;
    moment += power * (static_cast<double>(i) - static_cast<double>(k));
  }
  return static_cast<double>(k) + moment / sum;
}

}  // namespace

std::vector<OrderPeak> find_peaks(const OrderSpectrum& spectrum, std::size_t most) {
  const std::vector<double>& lines = spectrum.amplitude;
  if (lines.size() <= 2 * kWidth + 1) return {};
  const auto reach = static_cast<std::size_t>(std::lround(kPeakNeighbourhood / spectrum.step));
  const double least = kPeakLeast * *std::max_element(lines.begin() + kWidth + 1, lines.end() - kWidth);
  std::vector<OrderPeak> peaks;
  for (std::size_t k = kWidth + 1; k + kWidth < lines.size(); ++k) {
    const auto at = lines.begin() + static_cast<std::ptrdiff_t>(k);
    const std::ptrdiff_t width = kWidth;
    if (std::max_element(at - width, at + width + 1) != at || !(*at > least)) continue;
    if (*at < kPeakAbove * median_around(lines, k, reach)) continue;
    if (*at < kPeakAbove * std::max(valley(lines, k, -1), valley(lines, k, 1))) continue;
    peaks.push_back({centre(lines, k) * spectrum.step, *at});
  }
  std::sort(peaks.begin(), peaks.end(),
            [](const OrderPeak& a, const OrderPeak& b) { return a.amplitude > b.amplitude; });
  peaks.resize(std::min(peaks.size(), most));
  return peaks;
}

}  // namespace roadbalance
