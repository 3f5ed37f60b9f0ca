#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <string>

#include "common/config/vehicle_config.hpp"
#include "common/types/blocks.hpp"
#include "common/types/clocks.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {

/// Readings of channels while the car stands: means of the last seconds of each node's preview blocks.  A
/// pure state machine of bounded memory.
class StandstillReadings {
 public:
  static constexpr std::chrono::seconds kWindow{3};
  /// A car with its engine running shakes less, one that rolls shakes more: rms about the mean.
  static constexpr double kMostShaking_m_s2 = 1.0;

  void take(const ScanBlock& preview, WallTime now);

  struct Reading {
    std::array<double, kAccelerations> mean_counts{};
    std::string fault{};  ///< why there is none: the car moves, or too little has been heard
  };
  Reading of(const NodeConfig& node, WallTime now) const;

 private:
  struct Block {
    WallTime at{};
    int scans = 0;
    std::array<double, kAccelerations> sum{}, square{};  ///< of counts; squares about the first count
    std::array<std::int32_t, kReferences> least{}, most{};
  };
  struct Node {
    std::int64_t epoch = 0;
    std::array<std::int32_t, kAccelerations> first{};
    std::deque<Block> block;
  };
  std::map<std::int32_t, Node> nodes_;
};

}  // namespace roadbalance
