#include "host/analysis/orders/angle_variance.hpp"

#include <cmath>

namespace roadbalance {

AngleVariance doubt_of(const RecordOrders& found, const Rotor& rotor) {
  AngleVariance doubt{.located = rotor.known_share > 0.0 || rotor.ratio != 1.0};
  const double share = rotor.ratio / static_cast<double>(rotor.wheel.size());
  for (const int wheel : rotor.wheel) {
    const auto quality = found.angle.find(wheel);
    if (quality == found.angle.end()) continue;
    doubt.counted = true;
    doubt.by_speed = doubt.by_speed || quality->second.by_speed;
    doubt.located = doubt.located && quality->second.located;
    doubt.common_sigma_rad = std::hypot(doubt.common_sigma_rad, share * quality->second.common_sigma_rad);
    doubt.sigma_rad = std::hypot(doubt.sigma_rad, share * quality->second.sigma_rad);
    if (const std::string why = quality->second.contradiction(); !why.empty())
      doubt.contradiction += (doubt.contradiction.empty() ? "" : "; ") +
                             found.vehicle.wheel[static_cast<std::size_t>(wheel)].name + ": " + why;
  }
  return doubt;
}

}  // namespace roadbalance
