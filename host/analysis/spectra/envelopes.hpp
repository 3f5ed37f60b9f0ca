#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/bus/display.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/blocks.hpp"

namespace roadbalance {

/// The least and the greatest samples of one node's accelerations in buckets of about kBucket_s, of the last
/// kMostBuckets buckets.  Memory is fixed.
///
/// Bucket k holds scans k n .. k n + n - 1 of the node's epoch.  One that lacks a scan is NaN.
class EnvelopeMeter {
 public:
  static constexpr double kBucket_s = 0.005;

  explicit EnvelopeMeter(const NodeConfig& node);

  void add(const ScanBlock& block);

  /// The newest full buckets of a channel; nothing before the first is full or if there is no such channel.
  std::optional<Envelope> envelope(std::int32_t channel) const;

 private:
  struct Bucket {
    std::int32_t scans = 0;  ///< that came
    std::array<std::int32_t, kAccelerations> least{}, greatest{};
  };
  Bucket& bucket(std::int64_t number) {
    return ring_[static_cast<std::size_t>(number % static_cast<std::int64_t>(ring_.size()))];
  }
  void open(std::int64_t number);

  NodeConfig node_;
  std::int32_t scans_;        ///< in a bucket
  std::vector<Bucket> ring_;  ///< by number; one more than is sent, for that which is being filled
  std::int64_t epoch_ = 0, period_ps_ = 0;
  std::int64_t first_ = 0;               ///< oldest bucket held
  std::int64_t newest_ = -1;             ///< the one being filled; -1: none
  std::int64_t time_ns_ = 0, scan_ = 0;  ///< of a scan of the newest block: when, and which
};

}  // namespace roadbalance
