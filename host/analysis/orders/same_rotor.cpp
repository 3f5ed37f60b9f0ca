#include "host/analysis/orders/same_rotor.hpp"

#include <cmath>
#include <cstdio>

namespace roadbalance {
namespace {

std::string differs(const std::string& key, double one, double other) {
  if (one == other) return {};
  char text[100];
  std::snprintf(text, sizeof text, " is %.9g in one and %.9g in the other", one, other);
  return key + text;
}

std::string wheels_of(const RotorConfig& rotor) {
  std::string names;
  for (const int w : rotor.wheel) names += std::string(" ") + kWheelNames[static_cast<std::size_t>(w)];
  return names;
}

}  // namespace

std::string difference(const VehicleConfig& one, const VehicleConfig& other, const std::string& rotor) {
  const RotorConfig &a = *one.rotor_named(rotor), &b = *other.rotor_named(rotor);
  if (a.wheel != b.wheel)
    return "wheel of " + rotor + " is" + wheels_of(a) + " in one and" + wheels_of(b) + " in the other";
  if (auto why = differs("ratio of " + rotor, a.ratio, b.ratio); !why.empty()) return why;
  if (a.plane.size() != b.plane.size()) return rotor + " has not the same planes in both";
  for (std::size_t p = 0; p < a.plane.size(); ++p) {
    if (a.plane[p].name != b.plane[p].name)
      return "a plane of " + rotor + " is " + a.plane[p].name + " in one and " + b.plane[p].name +
             " in the other";
    const std::string key = "weight_radius_m of plane " + a.plane[p].name;
    if (auto why = differs(key, a.plane[p].weight_radius_m, b.plane[p].weight_radius_m); !why.empty())
      return why;
  }
  for (const int w : a.wheel) {
    const WheelConfig &left = one.wheel[static_cast<std::size_t>(w)],
                      &right = other.wheel[static_cast<std::size_t>(w)];
    auto why = differs("rolling_radius_m of " + left.name, left.rolling_radius_m, right.rolling_radius_m);
    if (!why.empty()) return why;
  }
  return differs("speed_class_m_s", one.drive.speed_class_m_s, other.drive.speed_class_m_s);
}

double datum_of(const VehicleConfig& vehicle, const RotorConfig& rotor) {
  double sum = 0.0;
  for (const int w : rotor.wheel) sum += vehicle.wheel[static_cast<std::size_t>(w)].encoder.datum_rad;
  return rotor.ratio * sum / static_cast<double>(rotor.wheel.size());
}

}  // namespace roadbalance
