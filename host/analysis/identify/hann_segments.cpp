#include "host/analysis/identify/hann_segments.hpp"

#include <cmath>

#include "common/types/angle_units.hpp"

namespace roadbalance {

HannSegments HannSegments::over(Eigen::Index samples, Eigen::Index size) {
  HannSegments segments;
  if (samples < size) return segments;
  const auto room = static_cast<double>(samples - size);
  const double hops = std::ceil(room / (kHannHop * static_cast<double>(size)));
  segments.weight = (kHannAlone + room / static_cast<double>(size)) / (hops + 1.0);
  for (double h = 0.0; h <= hops; h += 1.0)
    segments.begin.push_back(hops == 0.0 ? 0 : std::lround(h * room / hops));
  return segments;
}

std::vector<bool> bins_with_lines(std::size_t bins, Eigen::Index first, double step_hz,
                                  const Eigen::Vector4d& omega) {
  std::vector<bool> masked(bins, false);
  for (std::size_t k = 0; k < bins; ++k) {
    const double bin = static_cast<double>(first + static_cast<Eigen::Index>(k));
    for (const double rate : omega)
      for (int order = 1; order <= kForceOrders; ++order)
        if (rate > 0.0 && std::abs(bin - order * rate / (kTurn * step_hz)) < kLineBins) masked[k] = true;
  }
  return masked;
}

}  // namespace roadbalance
