#include "host/analysis/identify/drive_groups.hpp"

namespace roadbalance {

void DriveGroups::add(const SpeedClasses& drive) {
  const std::size_t place = drives_++ % kMost;
  if (place == group_.size()) group_.emplace_back();
  for (const auto& [key, each] : drive.classes()) group_[place][key] += each.total;
}

DriveMoments DriveGroups::total(std::size_t group) const {
  DriveMoments sum;
  for (const auto& [key, each] : group_[group]) sum += each;
  return sum;
}

std::vector<DriveMoments> DriveGroups::without(std::size_t group) const {
  std::map<int, DriveMoments> rest;
  for (std::size_t g = 0; g < group_.size(); ++g)
    if (g != group)
      for (const auto& [key, each] : group_[g]) rest[key] += each;
  std::vector<DriveMoments> all;
  for (const auto& [key, each] : rest) all.push_back(each);
  return all;
}

}  // namespace roadbalance
