#include "common/dbc/si_unit.hpp"

#include <numbers>

namespace roadbalance {
namespace {

struct Entry {
  std::string_view written;
  SiUnit unit;
};

constexpr SiUnit kPure{1.0, ""};
constexpr SiUnit kSpeed{1.0, "m/s"};
constexpr SiUnit kPerHour{1.0 / 3.6, "m/s"};
constexpr SiUnit kMilesPerHour{1609.344 / 3600.0, "m/s"};
constexpr SiUnit kAngle{1.0, "rad"};
constexpr SiUnit kDegree{std::numbers::pi / 180.0, "rad"};
constexpr SiUnit kTurning{1.0, "rad/s"};
constexpr SiUnit kDegreePerSecond{std::numbers::pi / 180.0, "rad/s"};
constexpr SiUnit kPerMinute{2.0 * std::numbers::pi / 60.0, "rad/s"};

// The degree sign stands in DBC files in Latin-1 or in UTF-8.
constexpr Entry kEntries[] = {
    {"", kPure},
    {"-", kPure},
    {"1", kPure},
    {"m/s", kSpeed},
    {"km/h", kPerHour},
    {"kph", kPerHour},
    {"mph", kMilesPerHour},
    {"rad", kAngle},
    {"deg", kDegree},
    {"degree", kDegree},
    {"\xB0", kDegree},
    {"\xC2\xB0", kDegree},
    {"rad/s", kTurning},
    {"deg/s", kDegreePerSecond},
    {"\xB0/s", kDegreePerSecond},
    {"\xC2\xB0/s", kDegreePerSecond},
    {"rpm", kPerMinute},
    {"1/min", kPerMinute},
};

}  // namespace

std::optional<SiUnit> si_unit(std::string_view unit) {
  for (const Entry& entry : kEntries)
    if (entry.written == unit) return entry.unit;
  return std::nullopt;
}

}  // namespace roadbalance
