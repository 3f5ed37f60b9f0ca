#pragma once

#include <array>
#include <functional>
#include <string>

#include "common/bus/results.hpp"
#include "host/analysis/twin/twin_shares.hpp"

namespace roadbalance {

/// The twin of a drive that is under way: by the latest estimate of the car, and until there is
/// one as vehicle.toml has it.
///
/// Blocks of each node in sequence; those that did not come are a hole, after which it settles anew.
class LiveTwin {
 public:
  using OnSecond = std::function<void(const TwinSecond&)>;
  static constexpr double kMemory_s = 30.0;  ///< of what is coherent

  /// @throws ConfigError as TwinChannels
  LiveTwin(const VehicleConfig& vehicle, OnSecond on_second);
  LiveTwin(const LiveTwin&) = delete;
  LiveTwin& operator=(const LiveTwin&) = delete;

  void consume(const SealedBlock& block) { samples_.consume(block); }
  void consume(const ClockFit& fit) { samples_.consume(fit); }
  void take(const Identification& identification);
  void take(const Balance& balance);

  const TwinChannels& channels() const { return channels_; }
  const TwinCar& car() const { return twin_.car(); }
  /// Why a node's samples cannot be brought to the grid of the others; empty: all can.
  std::string no_common_time() const { return samples_.no_common_time(); }

 private:
  void take_sample(const SensorSample& sample);

  VehicleConfig vehicle_;
  TwinChannels channels_;
  Twin twin_;
  TwinShares shares_;
  OnSecond on_second_;
  SensorSamples samples_;
  Identification identification_{};
  std::array<Balance, kWheels> balance_{};
  bool known_better_ = false;
};

}  // namespace roadbalance
