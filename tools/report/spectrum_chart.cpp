#include "tools/report/spectrum_chart.hpp"

#include <algorithm>
#include <cmath>

#include "common/text/format.hpp"
#include "common/text/markup.hpp"

namespace roadbalance {
namespace {

constexpr double kWidth = 340.0, kHeight = 140.0, kLeft = 34.0, kRight = 14.0, kTop = 30.0, kBottom = 16.0;
constexpr double kFirst_hz = 0.5;
constexpr double kMostDecades = 8.0;  // below is the noise of the arithmetic
constexpr std::size_t kMostPeaks = 3;
constexpr double kLabelWidth = 44.0, kLabelHeight = 9.0;
constexpr double kLeastAverages = 8.0;  // a single segment's lines go down to nothing by chance

/// How much lower the land falls before it rises above `density[bin]` on one side.
double lowest_towards(const std::vector<double>& density, std::size_t bin, std::size_t first, bool up) {
  double lowest = density[bin];
  for (std::size_t k = bin; up ? k + 1 < density.size() : k > first;) {
    k = up ? k + 1 : k - 1;
    if (density[k] > density[bin]) break;
    lowest = std::min(lowest, density[k]);
  }
  return lowest;
}

/// The part of the plane that is drawn, in decades.
struct Axes {
  double x0, x1, y0, y1;

  double x(double hz) const { return kLeft + (kWidth - kLeft - kRight) * (std::log10(hz) - x0) / (x1 - x0); }
  double y(double value) const {
    const double decades = value > 0.0 ? std::max(std::log10(value), y0) : y0;
    return kTop + (kHeight - kTop - kBottom) * (y1 - decades) / (y1 - y0);
  }
};

std::string line(double x0, double y0, double x1, double y1) {
  return format("<path class=\"grid\" d=\"M%.1f %.1fL%.1f %.1f\"/>", x0, y0, x1, y1);
}

std::string label(double x, double y, const char* anchor, const std::string& text) {
  return format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">", x, y, anchor) + markup_text(text) +
         "</text>";
}

std::string grid(const Axes& axes) {
  std::string svg;
  for (const double hz : {0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1e3, 2e3, 5e3, 1e4}) {
    if (std::log10(hz) > axes.x1) break;
    svg += line(axes.x(hz), kTop, axes.x(hz), kHeight - kBottom) +
           label(axes.x(hz), kHeight - 6.0, "middle", format("%g", hz));
  }
  const int every = axes.y1 - axes.y0 > 4.0 ? 2 : 1;
  for (int decade = static_cast<int>(axes.y0); decade <= static_cast<int>(axes.y1); decade += every) {
    const double y = axes.y(std::pow(10.0, decade));
    svg += line(kLeft, y, kWidth - kRight, y) + label(kLeft - 3.0, y + 3.0, "end", format("1e%d", decade));
  }
  return svg;
}

/// One point for each half unit of width, the highest that falls on it.
std::string curve(const std::vector<double>& density, double step_hz, std::size_t first, const Axes& axes) {
  std::string path;
  bool was_drawn = false;
  for (std::size_t k = first; k < density.size();) {
    std::size_t highest = k;
    const double until = axes.x(static_cast<double>(k) * step_hz) + 0.5;
    for (; k < density.size() && axes.x(static_cast<double>(k) * step_hz) < until; ++k)
      if (density[k] > density[highest]) highest = k;
    const bool is_drawn = density[highest] >= std::pow(10.0, axes.y0);
    if (is_drawn)
      path += format("%s%.1f %.1f", was_drawn ? "L" : "M", axes.x(static_cast<double>(highest) * step_hz),
                     axes.y(density[highest]));
    was_drawn = is_drawn;
  }
  return "<path class=\"curve\" d=\"" + path + "\"/>";
}

std::string marks(const std::vector<double>& density, double step_hz, std::size_t first, double averages,
                  const Axes& axes) {
  std::string svg;
  std::vector<double> rows(kMostPeaks, -kWidth);  // x of the last label in each
  auto peaks = spectrum_peaks(density, first, averages, kMostPeaks);
  std::ranges::sort(peaks, {}, &SpectrumPeak::bin);
  for (const SpectrumPeak& peak : peaks) {
    const double hz = static_cast<double>(peak.bin) * step_hz, x = axes.x(hz), y = axes.y(density[peak.bin]);
    const auto row = std::ranges::find_if(rows, [&](double last) { return x - last > kLabelWidth; });
    *row = x;
    const double label_y = 8.0 + kLabelHeight * static_cast<double>(row - rows.begin());
    svg += line(x, label_y + 1.5, x, y - 5.0) +
           format("<path class=\"peak\" d=\"M%.1f %.1fl-3 -5h6z\"/>", x, y - 1.0) +
           label(x, label_y, "middle", format("%.2f Hz", hz));
  }
  return svg;
}

}  // namespace

std::vector<SpectrumPeak> spectrum_peaks(const std::vector<double>& density, std::size_t first,
                                         double averages, std::size_t most) {
  const double least = std::max(4.0, std::exp(8.0 / std::sqrt(averages)));
  std::vector<SpectrumPeak> peaks;
  if (averages < kLeastAverages) return peaks;
  for (std::size_t k = first + 1; k + 1 < density.size(); ++k) {
    if (density[k] <= density[k - 1] || density[k] < density[k + 1]) continue;
    const double valley =
        std::max(lowest_towards(density, k, first, false), lowest_towards(density, k, first, true));
    if (valley > 0.0 && density[k] / valley < least) continue;
    peaks.push_back({k, valley > 0.0 ? density[k] / valley : INFINITY});
  }
  std::ranges::sort(peaks, [&](const SpectrumPeak& a, const SpectrumPeak& b) {
    return a.prominence != b.prominence ? a.prominence > b.prominence : density[a.bin] > density[b.bin];
  });
  if (peaks.size() > most) peaks.resize(most);
  return peaks;
}

std::string spectrum_chart(const std::vector<double>& density, double step_hz, double averages) {
  const auto first = static_cast<std::size_t>(std::ceil(kFirst_hz / step_hz));
  std::string svg = format("<svg class=\"chart\" viewBox=\"0 0 %.0f %.0f\" role=\"img\">", kWidth, kHeight);
  if (density.size() < first + 2) return svg + "</svg>";
  const double highest =
      *std::max_element(density.begin() + static_cast<std::ptrdiff_t>(first), density.end());
  if (!(highest > 0.0) || !std::isfinite(highest))
    return svg + label(kWidth / 2.0, kHeight / 2.0, "middle", "nothing but zero") + "</svg>";
  const double lowest =
      std::max(*std::min_element(density.begin() + static_cast<std::ptrdiff_t>(first), density.end()),
               highest * std::pow(10.0, -kMostDecades));
  const Axes axes{std::log10(kFirst_hz), std::log10(static_cast<double>(density.size() - 1) * step_hz),
                  std::floor(std::log10(lowest)), std::ceil(std::log10(highest) + 0.1)};
  return svg + grid(axes) + curve(density, step_hz, first, axes) +
         marks(density, step_hz, first, averages, axes) + "</svg>";
}

}  // namespace roadbalance
