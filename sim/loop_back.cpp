#include "sim/loop_back.hpp"

#include <cmath>

namespace roadbalance::sim {

LoopBack::LoopBack(const VehicleConfig& vehicle, const NodeConfig& node, const DrawnCar& car, double rate_hz)
    : wanted_(node.wiring.loop_back),
      rate_hz_(rate_hz),
      filter_(discretise_ramp_invariant(butterworth(vehicle.filter.order, vehicle.filter.cutoff_hz),
                                        1.0 / (rate_hz * kCodesPerScan)),
              kReferences) {
  for (std::size_t line = 0; line < kEncoderLines; ++line)
    if (const WheelConfig* const wheel = vehicle.wheel_at(node, static_cast<int>(line))) {
      const auto w = static_cast<std::size_t>(vehicle.place_of(*wheel));
      wheel_.push_back({line, car.rolling_radius_m[w], car.initial_angle_rad[w]});
    }
}

void LoopBack::convert(const Drive& drive, std::int64_t scan, Scan& out) {
  if (!wanted_) return;
  Eigen::Array<double, kReferences, 1> code = Eigen::Array<double, kReferences, 1>::Zero();
  for (int k = 1; k <= kCodesPerScan; ++k) {
    const double time_s = (static_cast<double>(scan - 1) + static_cast<double>(k) / kCodesPerScan) / rate_hz_;
    const double position_m = drive.at(time_s).position_m;
    for (const Wheel& wheel : wheel_) {
      const double angle_rad = position_m / wheel.radius_m + wheel.initial_rad;
      const auto row = static_cast<Eigen::Index>(2 * wheel.line);
      code(row) = std::round(32767.0 * kAmplitude * std::sin(angle_rad)) / 32767.0;
      code(row + 1) = std::round(32767.0 * kAmplitude * std::cos(angle_rad)) / 32767.0;
    }
    filter_.update(code);
  }
  for (std::size_t r = 0; r < kReferences; ++r)
    out.references[r] = static_cast<std::int32_t>(
        std::lround(filter_.states()(static_cast<Eigen::Index>(r), 0) * kFullScaleCounts));
}

}  // namespace roadbalance::sim
