#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/types/scan.hpp"
#include "sim/car.hpp"

namespace roadbalance::sim {

/// The analogue half of a node and its converter: the car's motion becomes twelve 24-bit counts.
///
///     sources ─▶ sensors (place, direction, coupling, noise) ─▶ preamplifier (range) ─▶ anti-aliasing filter
///     ─▶ counts
///
/// Runs at twice the scan rate.  The filter is the Butterworth filter of vehicle.toml, ramp-invariant at that
/// rate: no phase error, gain too small by (pi f step)^2 / 3 (7e-5 at 18 Hz and 0.25 ms).  Noise is white
/// before the filter, so strong that sensor.noise_m_s2 is its rms behind it.  A channel of role road carries
/// the road height under its wheel (metres instead of m/s^2), without noise.
class Conditioner {
 public:
  /// @param step_s  half a scan
  Conditioner(const Scenario& scenario, std::uint64_t seed, const VehicleConfig& vehicle,
              const NodeConfig& node, double step_s);

  /// Takes what the car does at `step`.  Never allocates.
  void feed(const SourceVector& sources, std::int64_t step);

  /// Converts what the filter shows now.  Overload is reported once: of every step since the last conversion.
  void convert(Scan& scan);

 private:
  static constexpr int kMaximumOrder = 12;
  using Channels = Eigen::Array<double, kAccelerations, 1>;

  void wire(int row, const ChannelConfig& channel, const SensorScenario& sensor);
  void design_filter(const FilterConfig& filter, double step_s);
  double filter_noise_gain() const;

  Eigen::Matrix<double, kAccelerations, kSources> wiring_;  ///< sources to sensor signals
  Channels range_, noise_, counts_per_unit_, offset_counts_;
  std::vector<RandomSequence> random_;  ///< one a channel

  int order_;
  Eigen::Matrix<double, kMaximumOrder, kMaximumOrder> transition_;
  Eigen::Array<double, kMaximumOrder, 1> before_, now_;
  std::array<Channels, kMaximumOrder> state_;  ///< state 0 is the filter's output
  Channels last_;
  std::uint32_t overload_ = 0;
};

}  // namespace roadbalance::sim
