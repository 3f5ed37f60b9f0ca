#pragma once

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "common/bus/results.hpp"
#include "host/analysis/identify/moments.hpp"

namespace roadbalance {

/// The moments of a drive: sections of about one speed together, dealt out to the jackknife's groups in turn.
/// Memory is bounded by the speeds driven, not by the length of the drive.
class SpeedClasses {
 public:
  static constexpr std::size_t kGroups = 10;  ///< of a class

  struct Class {
    std::array<DriveMoments, kGroups> group;
    DriveMoments total;
  };

  explicit SpeedClasses(double width_m_s) : width_m_s_(width_m_s) {}
  SpeedClasses(double width_m_s, std::map<int, Class> classes)
      : width_m_s_(width_m_s), class_(std::move(classes)) {}

  void add(const DriveMoments& section);
  /// Another drive of the same width, its groups dealt out in turn after those there are.
  void add(const SpeedClasses& drive);
  /// DriveMoments::weigh_road of all.
  void weigh_road(double factor);

  double width_m_s() const { return width_m_s_; }
  const std::map<int, Class>& classes() const { return class_; }  ///< by speed over width

  bool empty() const { return class_.empty(); }
  int sections() const;
  /// Groups of all classes, those that hold sections; their sum is the drive.
  std::vector<DriveMoments> groups() const;
  /// Totals of each class, slowest first.
  std::vector<DriveMoments> totals() const;
  DriveMoments total() const;
  /// The totals without one of the groups(), which is of that class; empty: it was all of it.
  struct LeftOut {
    std::size_t which;
    DriveMoments total;
  };
  std::vector<LeftOut> left_out() const;

 private:
  double width_m_s_;
  std::map<int, Class> class_;
};

}  // namespace roadbalance
