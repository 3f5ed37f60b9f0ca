#include "host/analysis/identify/extra_variance.hpp"

#include <cmath>
#include <optional>
#include <string>

namespace roadbalance {
namespace {

/// Variance of the mean of the vertical channels at a place; nothing: there is none.
std::optional<double> variance_at(const VehicleConfig& vehicle, const std::string& mount) {
  double sum = 0.0, channels = 0.0;
  for (const NodeConfig& node : vehicle.node)
    for (const ChannelConfig& channel : node.channel) {
      const double vertical = channel.direction.z() * channel.direction.z();
      if (channel.role != ChannelRole::kAcceleration || channel.mount != mount || vertical < 0.5) continue;
      sum += channel.gain_sigma * channel.gain_sigma;
      channels += 1.0;
    }
  if (channels == 0.0) return std::nullopt;
  return sum / (channels * channels);
}

}  // namespace

void add_variance(Balance& balance, double along, double across) {
  const Eigen::Vector2d vector =
      balance.unbalance_g * Eigen::Vector2d(std::cos(balance.angle_rad), std::sin(balance.angle_rad));
  const Eigen::Vector2d turned(-vector.y(), vector.x());
  balance.covariance_g2 += along * vector * vector.transpose() + across * turned * turned.transpose();
  balance.sigma_g = std::hypot(balance.sigma_g, balance.unbalance_g * std::sqrt(along));
  balance.sigma_rad = std::hypot(balance.sigma_rad, std::sqrt(across));
}

double gain_variance(const VehicleConfig& vehicle, std::size_t wheel) {
  if (const auto own = variance_at(vehicle, kWheelNames[wheel])) return *own;
  return variance_at(vehicle, "body").value_or(0.0);
}

}  // namespace roadbalance
