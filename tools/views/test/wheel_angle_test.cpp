#include "tools/views/wheel_angle.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace roadbalance {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

TEST(WheelAngle, IsInTheDirectionOfRotationOnBothSidesOfTheCar) {
  for (const bool left : {false, true}) {
    EXPECT_NEAR(*parse_wheel_angle("45", left) * kDegrees, 45.0, 1e-9);
    EXPECT_NEAR(*parse_wheel_angle("-30.5 deg", left) * kDegrees, 329.5, 1e-9);
    EXPECT_NEAR(*parse_wheel_angle("360", left) * kDegrees, 0.0, 1e-9);
    EXPECT_NEAR(*parse_wheel_angle(" 12:00", left) * kDegrees, 0.0, 1e-9);
    EXPECT_NEAR(*parse_wheel_angle("6:00 ", left) * kDegrees, 180.0, 1e-9);
  }
  // Driving forward the upper half goes to the front: seen from outside to the right on the car's right
  // side, to the left on its left side.  A point that has turned by 90 degrees stands in front.
  EXPECT_NEAR(*parse_wheel_angle("3:00", false) * kDegrees, 90.0, 1e-9);
  EXPECT_NEAR(*parse_wheel_angle("9:00", true) * kDegrees, 90.0, 1e-9);
  EXPECT_NEAR(*parse_wheel_angle("10:30", true) * kDegrees, 45.0, 1e-9);
  EXPECT_NEAR(*parse_wheel_angle("12:10", false) * kDegrees, 5.0, 1e-9);
  EXPECT_NEAR(*parse_wheel_angle("0:10", true) * kDegrees, 355.0, 1e-9);
}

TEST(WheelAngle, IsSaidAsItIsRead) {
  for (const bool left : {false, true})
    for (const char* clock : {"12:00", "12:59", "1:00", "3:07", "11:59"})
      EXPECT_EQ(clock_of(*parse_wheel_angle(clock, left), left), clock);
  EXPECT_EQ(clock_of(2.0 * std::numbers::pi - 1e-9, true), "12:00");
}

TEST(WheelAngle, IsNoHourWithoutMinutes) {
  for (int hour = 1; hour <= 12; ++hour) EXPECT_FALSE(parse_wheel_angle(std::to_string(hour), true)) << hour;
  EXPECT_FALSE(parse_wheel_angle(" 09 ", true));
  for (const char* text : {"10°", "10 deg", "10.0", "+10"})
    EXPECT_NEAR(*parse_wheel_angle(text, true) * kDegrees, 10.0, 1e-9) << text;
  EXPECT_NEAR(*parse_wheel_angle("0", true), 0.0, 1e-9);
  EXPECT_NEAR(*parse_wheel_angle("13", true) * kDegrees, 13.0, 1e-9);
}

TEST(WheelAngle, IsNothingElse) {
  for (const char* text : {"", "x", "3:60", "14:00", "400", "45 grad", "3:0", "1e2", "--4", "4:30:00"})
    EXPECT_FALSE(parse_wheel_angle(text, true)) << text;
}

// Half a metre of radius: an angle of 1 rad is 500 mm of rim.
TEST(AlongRim, GoesTheShorterWayRound) {
  EXPECT_EQ(along_rim(1.0, 0.5), "500 mm ahead of the valve");
  EXPECT_EQ(along_rim(-1.0, 0.5), "500 mm behind the valve");
  EXPECT_EQ(along_rim(2.0 * std::numbers::pi - 1.0, 0.5), "500 mm behind the valve");
  EXPECT_EQ(along_rim(2.0 * std::numbers::pi + 1.0, 0.5), "500 mm ahead of the valve");
  EXPECT_EQ(along_rim(0.0, 0.5), "0 mm ahead of the valve");
}

}  // namespace
}  // namespace roadbalance
