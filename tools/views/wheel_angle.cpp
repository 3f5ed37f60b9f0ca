#include "tools/views/wheel_angle.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <regex>

#include "common/text/format.hpp"

namespace roadbalance {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;
constexpr double kHours = 12.0;

double reduced(double turns) {
  return kTurn_rad * (turns - std::floor(turns));
}

}  // namespace

std::optional<double> parse_wheel_angle(const std::string& text, bool left_side) {
  static const std::regex kClock(R"(\s*(\d{1,2}):([0-5]\d)\s*)");
  static const std::regex kDegrees(R"(\s*([+-]?\d{1,3}(\.\d*)?)\s*(deg|°)?\s*)");
  std::smatch found;
  if (std::regex_match(text, found, kClock)) {
    const double hours = std::stod(found[1]) + std::stod(found[2]) / 60.0;
    if (hours > kHours + 1.0) return std::nullopt;
    return reduced((left_side ? -hours : hours) / kHours);
  }
  if (!std::regex_match(text, found, kDegrees)) return std::nullopt;
  static const std::regex kHour(R"(\s*0?([1-9]|1[0-2])\s*)");
  if (std::regex_match(text, kHour)) return std::nullopt;  // of the clock, or degrees?
  const double degrees = std::stod(found[1]);
  if (std::abs(degrees) > 360.0) return std::nullopt;
  return reduced(degrees / 360.0);
}

std::string clock_of(double angle_rad, bool left_side) {
  constexpr int kMinutes = 12 * 60;
  const double turns = (left_side ? -angle_rad : angle_rad) / kTurn_rad;
  const int minute = static_cast<int>(std::lround(reduced(turns) / kTurn_rad * kMinutes)) % kMinutes;
  char text[16];
  std::snprintf(text, sizeof text, "%d:%02d", minute < 60 ? 12 : minute / 60, minute % 60);
  return text;
}

std::string along_rim(double angle_rad, double radius_m) {
  const double shorter_rad = std::remainder(angle_rad, 2.0 * std::numbers::pi);
  return format("%.0f mm %s the valve", 1e3 * radius_m * std::abs(shorter_rad),
                shorter_rad < 0.0 ? "behind" : "ahead of");
}

}  // namespace roadbalance
