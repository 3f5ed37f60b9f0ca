#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "common/dsp/linear_filter.hpp"
#include "common/types/scan.hpp"
#include "sim/car.hpp"

namespace roadbalance::sim {

/// The analogue half of a node and its converter: the car's motion becomes twelve 24-bit counts.
///
///     sources ─▶ bracket, sensor (place, direction, coupling, gain, noise) ─▶ preamplifier (range)
///     ─▶ anti-aliasing filter ─▶ counts
///
/// Runs at twice the scan rate.  The filter is the Butterworth filter of vehicle.toml, but for its
/// components' tolerance, ramp-invariant at that rate: no phase error, gain too small by (pi f step)^2 / 3
/// (7e-5 at 18 Hz and 0.25 ms).  Noise is white before the filter, so strong that sensor.noise_m_s2 is its
/// rms behind it.  A channel of role road carries the road height under its wheel (metres instead of m/s^2),
/// without faults.
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

  void wire(int row, const ChannelConfig& channel, const SensorScenario& sensor,
            const RandomSequence& random);
  void put_on_bracket(int row, double frequency_hz, double damping, double step_s);
  void set_filter(int row, const DiscreteFilter& filter);
  Channels behind_brackets(const Channels& moved);

  Eigen::Matrix<double, kAccelerations, kSources> wiring_;  ///< sources to sensor signals
  Channels range_, clips_at_, noise_, counts_per_unit_, offset_counts_;
  std::vector<RandomSequence> random_;  ///< one a channel

  /// A resonator of two states: state = transition state + before input_last + now input, signal = out state.
  struct Brackets {
    std::array<std::array<Channels, 2>, 2> transition;
    std::array<Channels, 2> before, now, out, state;
    Channels through, last;  ///< of the input: 1 where there is no bracket
  };
  std::optional<Brackets> brackets_;

  int order_;
  std::array<std::array<Channels, kMaximumOrder>, kMaximumOrder> transition_;
  std::array<Channels, kMaximumOrder> before_, now_;
  std::array<Channels, kMaximumOrder> state_;  ///< state 0 is the filter's output
  Channels last_;
  std::uint32_t overload_ = 0;
};

}  // namespace roadbalance::sim
