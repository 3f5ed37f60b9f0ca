#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "common/bus/results.hpp"
#include "common/clock/clock_table.hpp"

namespace roadbalance {

/// Hands on the levels of all nodes of a record in the order of their time.
///
/// A record holds blocks as they came: after a cable was pulled one node's are those of long ago, and where
/// time runs faster than real, nodes are not in step at all.
class LevelsInTime {
 public:
  /// A level that comes later than so much behind the newest is handed on at once.
  static constexpr std::int64_t kWindow_ns = 120'000'000'000;

  explicit LevelsInTime(std::function<void(const Level&)> consume) : consume_(std::move(consume)) {}

  /// A fit of a node's clock.  In a record without any, all nodes have the same time.
  void take(const ClockFit& fit);
  /// @param epoch  of the node's blocks; while its clock is not known, a level's time is when it came
  void take(std::int64_t epoch, const Level& level);
  /// Hands on what waits; at the end of the record.
  void flush();

 private:
  std::int64_t time_ns(std::int64_t epoch, const Level& level) const;

  std::function<void(const Level&)> consume_;
  ClockTable clocks_;
  /// By time; of one time the first node last, whose levels are WheelSpeeds' instants.
  std::multimap<std::pair<std::int64_t, std::int32_t>, Level> waiting_;
};

}  // namespace roadbalance
