#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/orders/grid_join.hpp"

namespace roadbalance {

/// Some of a node's accelerations in m/s^2, counted anew from 0.
class SiChannels {
 public:
  /// @param channel  places in the node's, as NodeConfig::channel has them
  SiChannels(const NodeConfig& node, const std::vector<std::size_t>& channel);

  Eigen::Index size() const { return std::ssize(channel_); }
  /// @param values  [channel]
  /// @return  bit k: channel k left its range
  std::uint32_t read(const GridJoin::Sample& sample, Eigen::Ref<Eigen::VectorXd> values) const;

 private:
  struct Channel {
    std::size_t place;
    double offset_counts, scale;  ///< NodeConfig::channel has them, too, far apart
  };
  std::vector<Channel> channel_;
};

}  // namespace roadbalance
