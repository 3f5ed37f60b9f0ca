#include "host/recording/subset/reduction.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

int of(double rate_hz, double cutoff_hz) {
  VehicleConfig vehicle;
  vehicle.node.resize(1);
  vehicle.node.front().rate_hz = rate_hz;
  vehicle.filter.cutoff_hz = cutoff_hz;
  return largest_reduction(vehicle);
}

TEST(Reduction, LeavesMoreThanTwiceTheCutoff) {
  EXPECT_EQ(of(2000, 200), 4) << "500 Hz; 400 Hz is not more than 400 Hz";
  EXPECT_EQ(of(2001, 200), 5);
  EXPECT_EQ(of(1999, 200), 4);
  EXPECT_EQ(of(100'000, 0.1), 499'999);
}

TEST(Reduction, IsNoneWhereTheFilterPassesAQuarterOfTheRate) {
  EXPECT_EQ(of(800, 200), 1);
  EXPECT_EQ(of(500, 200), 1);
  EXPECT_EQ(of(801, 200), 2);
}

}  // namespace
}  // namespace roadbalance
