#include "tools/views/overall_lines.hpp"

#include <cmath>
#include <numbers>

#include "common/text/format.hpp"
#include "host/analysis/balance/weight_choice.hpp"
#include "host/analysis/balance/weight_plan.hpp"
#include "tools/views/compensation_json.hpp"
#include "tools/views/degrees.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// 0 .. 359
double degrees_of_turn(double angle_rad) {
  return std::fmod(std::round(degrees(wrap_turn(angle_rad))), 360.0);
}

std::string steps_of(const OverallPlan::Wheel& wheel) {
  std::string steps;
  for (const WeightStep& step : wheel.plan.step)
    steps += (steps.empty() ? "" : ", ") + to_string(step, wheel.radii);
  return steps.empty() ? "leave it" : steps;
}

/// Two digits: the forces that this follows from are known to a few percent.
std::string row(const std::string& what, const SeatVibration& vibration) {
  return format("  %-14s %8.2g %9.2g %8.2g %8.2g", what.c_str(), vibration.now, vibration.by_wheel,
                vibration.overall, vibration.least);
}

/// Line of a wheel whose force is unknown at some speeds; empty: it is known at all of them.
std::string missing_line(const OverallPlan& plan, std::size_t wheel) {
  std::string speeds;
  bool at_all = true;
  for (const OverallPlan::Speed& speed : plan.speed)
    if (speed.without_force[wheel])
      speeds += (speeds.empty() ? "" : ", ") + format("%.0f", 3.6 * speed.speed_m_s);
    else
      at_all = false;
  if (speeds.empty()) return {};
  if (at_all)
    return format(
        "  NOT KNOWN: what turns with %s, at no speed: its weights are its own, its share in no figure",
        kWheelNames[wheel]);
  return format(
      "  NOT KNOWN: what turns with %s at %s km/h: not in those speeds' figures, nor in its best weight",
      kWheelNames[wheel], speeds.c_str());
}

Json vibration_json(const SeatVibration& vibration) {
  return {{"now_m_s2", vibration.now},
          {"by_wheel_m_s2", vibration.by_wheel},
          {"overall_m_s2", vibration.overall},
          {"least_m_s2", vibration.least}};
}

}  // namespace

std::vector<std::string> overall_lines(const OverallPlan& plan) {
  std::string seats;
  for (const SeatConfig& seat : plan.seat) seats += (seats.empty() ? "" : ", ") + seat.name;
  std::vector<std::string> lines{"overall compensation, least vertical vibration at " + seats};
  for (std::size_t w = 0; w < kWheels; ++w) {
    const WheelWeight& best = plan.wheel[w].best;
    std::string line = format("  %-12s ", kWheelNames[w]) + steps_of(plan.wheel[w]);
    if (best.mass_g > 0.0)
      line += format("  (best %.1f g at %.0f°)", best.mass_g, degrees_of_turn(best.angle_rad));
    lines.push_back(line);
  }
  lines.emplace_back("  what turns with the wheels there, m/s² rms, predicted by the identified car:");
  lines.emplace_back("  speed               now  by wheel  overall     best");
  for (const OverallPlan::Speed& speed : plan.speed)
    lines.push_back(row(format("%.0f km/h %.0f s", 3.6 * speed.speed_m_s, speed.seconds), speed.vibration));
  lines.push_back(row("all", plan.vibration));
  for (std::size_t w = 0; w < kWheels; ++w)
    if (const std::string line = missing_line(plan, w); !line.empty()) lines.push_back(line);
  return lines;
}

Json overall_json(const OverallPlan& plan) {
  Json seats = Json::array(), wheels = Json::array(), speeds = Json::array();
  for (const SeatConfig& seat : plan.seat)
    seats.push_back({{"name", seat.name},
                     {"position_m", {seat.position_m.x(), seat.position_m.y(), seat.position_m.z()}},
                     {"weight", seat.weight}});
  for (std::size_t w = 0; w < kWheels; ++w) {
    const WheelWeight& best = plan.wheel[w].best;
    wheels.push_back({{"name", kWheelNames[w]},
                      {"best_g", best.mass_g},
                      {"best_deg", degrees_of_turn(best.angle_rad)},
                      {"steps", steps_json(plan.wheel[w].plan)}});
  }
  for (const OverallPlan::Speed& speed : plan.speed) {
    speeds.push_back({{"speed_km_h", 3.6 * speed.speed_m_s}, {"seconds", speed.seconds}});
    speeds.back().update(vibration_json(speed.vibration));
    Json without = Json::array();
    for (std::size_t w = 0; w < kWheels; ++w)
      if (speed.without_force[w]) without.push_back(kWheelNames[w]);
    speeds.back()["without_force"] = without;
  }
  return {{"seats", seats}, {"wheels", wheels}, {"speeds", speeds}, {"all", vibration_json(plan.vibration)}};
}

}  // namespace roadbalance
