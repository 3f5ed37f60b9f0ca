#include "host/analysis/identify/speed_classes.hpp"

namespace roadbalance {

void SpeedClasses::add(const DriveMoments& section) {
  const double speed_m_s = section.speed_seconds / section.seconds;
  Class& found = class_[static_cast<int>(speed_m_s / width_m_s_)];
  found.group[static_cast<std::size_t>(found.total.sections) % kGroups] += section;
  found.total += section;
}

void SpeedClasses::add(const SpeedClasses& drive) {
  for (const auto& [key, each] : drive.class_) {
    Class& found = class_[key];
    const auto before = static_cast<std::size_t>(found.total.sections);
    for (std::size_t g = 0; g < kGroups; ++g)
      if (each.group[g].sections > 0) found.group[(before + g) % kGroups] += each.group[g];
    found.total += each.total;
  }
}

void SpeedClasses::weigh_road(double factor) {
  for (auto& [key, each] : class_) {
    for (DriveMoments& group : each.group) group.weigh_road(factor);
    each.total.weigh_road(factor);
  }
}

int SpeedClasses::sections() const {
  int sum = 0;
  for (const auto& [key, each] : class_) sum += each.total.sections;
  return sum;
}

std::vector<DriveMoments> SpeedClasses::groups() const {
  std::vector<DriveMoments> all;
  for (const auto& [key, each] : class_)
    for (const DriveMoments& group : each.group)
      if (group.sections > 0) all.push_back(group);
  return all;
}

std::vector<DriveMoments> SpeedClasses::totals() const {
  std::vector<DriveMoments> all;
  for (const auto& [key, each] : class_) all.push_back(each.total);
  return all;
}

DriveMoments SpeedClasses::total() const {
  DriveMoments sum;
  for (const auto& [key, each] : class_) sum += each.total;
  return sum;
}

std::vector<SpeedClasses::LeftOut> SpeedClasses::left_out() const {
  std::vector<LeftOut> all;
  std::size_t which = 0;
  for (const auto& [key, each] : class_) {
    for (std::size_t out = 0; out < kGroups; ++out) {
      if (each.group[out].sections == 0) continue;
      LeftOut rest{which, {}};
      for (std::size_t g = 0; g < kGroups; ++g)
        if (g != out) rest.total += each.group[g];
      all.push_back(rest);
    }
    ++which;
  }
  return all;
}

}  // namespace roadbalance
