#pragma once

#include <optional>
#include <string>

namespace roadbalance {

/// The angle of a point of a wheel, as people say it: degrees in the direction of forward rotation from the
/// upward vertical ("45", "-30", "45.5deg"), or the hour of a clock laid on the wheel as it is seen from
/// outside the car ("10:30", "3:00"), which runs against the rotation on the left side of the car
/// (common/vehicle/conventions.md).
/// @return radians 0 .. 2 pi; nothing if it is neither
std::optional<double> parse_wheel_angle(const std::string& text, bool left_side);

/// The same backwards: "10:30".
std::string clock_of(double angle_rad, bool left_side);

/// With a ruler, the shorter way: "123 mm ahead of the valve" along the rim, in the direction of rotation, or
/// "123 mm behind the valve".
/// @param angle_rad  from the reference point in the direction of rotation
std::string along_rim(double angle_rad, double radius_m);

}  // namespace roadbalance
