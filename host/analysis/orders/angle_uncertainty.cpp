#include "host/analysis/orders/angle_uncertainty.hpp"

#include <cmath>

namespace roadbalance {

AngleUncertainty angle_uncertainty(const RecordOrders& found, const Rotor& rotor) {
  AngleUncertainty uncertainty{.located = rotor.known_share > 0.0 || rotor.ratio != 1.0};
  const double share = rotor.ratio / static_cast<double>(rotor.wheel.size());
  for (const int wheel : rotor.wheel) {
    const auto quality = found.angle.find(wheel);
    if (quality == found.angle.end()) continue;
    uncertainty.counted = true;
    uncertainty.by_speed = uncertainty.by_speed || quality->second.by_speed;
    uncertainty.located = uncertainty.located && quality->second.located;
    uncertainty.common_sigma_rad =
        std::hypot(uncertainty.common_sigma_rad, share * quality->second.common_sigma_rad);
    uncertainty.sigma_rad = std::hypot(uncertainty.sigma_rad, share * quality->second.sigma_rad);
    if (const std::string why = quality->second.contradiction(); !why.empty())
      uncertainty.contradiction += (uncertainty.contradiction.empty() ? "" : "; ") +
                                   found.vehicle.wheel[static_cast<std::size_t>(wheel)].name + ": " + why;
  }
  return uncertainty;
}

}  // namespace roadbalance
