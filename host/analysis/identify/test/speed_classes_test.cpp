#include "host/analysis/identify/speed_classes.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

/// A section of 10 s that differs from others.
DriveMoments section(double speed_m_s, double mark) {
  DriveMoments moments;
  moments.sections = 1;
  moments.seconds = 10.0;
  moments.speed_seconds = 10.0 * speed_m_s;
  moments.chassis_power[0] = mark;
  return moments;
}

TEST(SpeedClasses, KeepSpeedsApartAndDealSectionsOutToGroups) {
  SpeedClasses drive(2.0);
  for (int k = 0; k < 25; ++k) drive.add(section(30.5, 1.0));
  drive.add(section(20.1, 100.0));
  EXPECT_EQ(drive.sections(), 26);
  ASSERT_EQ(drive.totals().size(), 2U);
  EXPECT_EQ(drive.totals()[0].chassis_power[0], 100.0) << "slowest first";
  ASSERT_EQ(drive.groups().size(), 1 + SpeedClasses::kGroups);
  EXPECT_EQ(drive.groups()[1].sections, 3);
  EXPECT_EQ(drive.groups()[10].sections, 2);
  EXPECT_EQ(drive.total().chassis_power[0], 125.0);
}

TEST(SpeedClasses, LeaveOutEachGroupOnce) {
  SpeedClasses drive(2.0);
  for (int k = 0; k < 14; ++k) drive.add(section(30.5, 1 << k));
  drive.add(section(20.1, 7.0));
  const auto groups = drive.groups();
  const auto left_out = drive.left_out();
  ASSERT_EQ(left_out.size(), groups.size());
  const auto totals = drive.totals();
  for (std::size_t g = 0; g < groups.size(); ++g) {
    EXPECT_EQ(left_out[g].which, g == 0 ? 0U : 1U);
    EXPECT_EQ(left_out[g].total.chassis_power[0] + groups[g].chassis_power[0],
              totals[left_out[g].which].chassis_power[0]);
  }
  EXPECT_EQ(left_out[0].total.sections, 0) << "all of its class";
}

}  // namespace
}  // namespace roadbalance
