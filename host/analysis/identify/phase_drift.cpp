#include "host/analysis/identify/phase_drift.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "common/types/angle_units.hpp"

namespace roadbalance {
void PhaseDrift::add(const Eigen::Ref<const SignalMatrix>& signals,
                     const std::array<bool, kWheels>& has_angle) {
  constexpr auto kPerRad = static_cast<double>(kCells) / kTurn;
  for (int a = 0; a < kWheels; ++a)
    for (int b = a + 1; b < kWheels; ++b) {
      if (!has_angle[static_cast<std::size_t>(a)] || !has_angle[static_cast<std::size_t>(b)]) continue;
      auto& cells = seen[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
      for (Eigen::Index k = 0; k < signals.cols(); ++k) {
        const double between =
            std::arg(reference(signals.col(k), a) * std::conj(reference(signals.col(k), b)));
        const auto cell = static_cast<std::size_t>((between + kTurn) * kPerRad);
        cells.set(cell % kCells);
      }
    }
}

void PhaseDrift::add(const PhaseDrift& other) {
  for (std::size_t a = 0; a < kWheels; ++a)
    for (std::size_t b = 0; b < kWheels; ++b) seen[a][b] |= other.seen[a][b];
}

std::optional<double> PhaseDrift::drift_rad(int a, int b) const {
  const auto [low, high] = std::minmax(a, b);
  const auto& cells = seen[static_cast<std::size_t>(low)][static_cast<std::size_t>(high)];
  if (cells.none()) return std::nullopt;
  // The arc is the turn without the longest run of empty cells; twice around meets every run whole.
  std::size_t longest = 0, empty = 0;
  for (std::size_t k = 0; k < 2 * kCells; ++k) {
    empty = cells.test(k % kCells) ? 0 : empty + 1;
    longest = std::max(longest, empty);
  }
  return static_cast<double>(kCells - longest) * kTurn / static_cast<double>(kCells);
}

std::array<std::optional<int>, kWheels> in_step(const PhaseDrift& drift) {
  std::array<std::optional<int>, kWheels> with;
  for (int a = 0; a < kWheels; ++a)
    for (int b = 0; b < kWheels; ++b) {
      if (a == b) continue;
      const auto between = drift.drift_rad(a, b);
      auto& found = with[static_cast<std::size_t>(a)];
      if (between && *between < kLeastDrift_rad && !found) found = b;
    }
  return with;
}

}  // namespace roadbalance
