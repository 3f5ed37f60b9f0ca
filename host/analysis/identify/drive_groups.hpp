#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "host/analysis/identify/moments.hpp"
#include "host/analysis/identify/speed_classes.hpp"

namespace roadbalance {

/// Whole drives of one car, dealt out in turn to groups: how far drives differ from one another.  Memory is
/// bounded by the speeds driven, not by the number of drives.
class DriveGroups {
 public:
  static constexpr std::size_t kMost = 40;

  void add(const SpeedClasses& drive);

  std::size_t size() const { return group_.size(); }
  /// All that one group holds.
  DriveMoments total(std::size_t group) const;
  /// Totals of each class of speed, slowest first, without that group.
  std::vector<DriveMoments> without(std::size_t group) const;

 private:
  std::vector<std::map<int, DriveMoments>> group_;  ///< by class of speed
  std::size_t drives_ = 0;
};

}  // namespace roadbalance
