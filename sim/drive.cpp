#include "sim/drive.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/random.hpp"

namespace roadbalance::sim {

Drive::Drive(const DriveScenario& scenario, std::uint64_t seed)
    : drift_m_s2_(scenario.drift_m_s2), end_s_(0.0) {
  double before_m_s = scenario.plateau.front().speed_m_s;
  Leg leg{0.0, 0.0, before_m_s, before_m_s, 0.0};
  for (const Plateau& plateau : scenario.plateau) {
    leg.speed_before_m_s = before_m_s;
    leg.speed_m_s = plateau.speed_m_s;
    leg.ramp_s = std::min(scenario.ramp_s, 0.5 * plateau.seconds);
    leg_.push_back(leg);
    leg.start_s += plateau.seconds;
    leg.start_m = on_leg(leg_.back(), leg.start_s).position_m;
    before_m_s = plateau.speed_m_s;
  }
  end_s_ = leg.start_s;
  const RandomSequence random(seed, Use::kWander, 0);
  for (std::size_t i = 0; i < wander_.size(); ++i) {
    const auto n = static_cast<std::int64_t>(i);
    // One period in each quarter of 7 .. 40 s on a logarithmic scale.
    const double period_s = 7.0 * std::pow(40.0 / 7.0, (static_cast<double>(i) + random.uniform(n)) / 4.0);
    wander_[i] = {0.5 * scenario.wander_m_s, 2.0 * std::numbers::pi / period_s,
                  2.0 * std::numbers::pi * random.uniform(n + 4)};
  }
}

Motion Drive::on_leg(const Leg& leg, double time_s) {
  const double elapsed_s = time_s - leg.start_s;
  const double step_m_s = leg.speed_m_s - leg.speed_before_m_s;
  if (elapsed_s >= leg.ramp_s || step_m_s == 0.0)
    return {leg.start_m - 0.5 * step_m_s * leg.ramp_s + leg.speed_m_s * elapsed_s, leg.speed_m_s, 0.0};
  // Smooth step x^3 (10 - 15 x + 6 x^2) with its integral and derivative.
  const double x = elapsed_s / leg.ramp_s;
  const double x2 = x * x;
  return {
      leg.start_m + leg.speed_before_m_s * elapsed_s + step_m_s * leg.ramp_s * x2 * x2 * (2.5 - 3.0 * x + x2),
      leg.speed_before_m_s + step_m_s * x * x2 * (10.0 - 15.0 * x + 6.0 * x2),
      step_m_s / leg.ramp_s * 30.0 * x2 * (1.0 - x) * (1.0 - x)};
}

Motion Drive::drift(double time_s) const {
  const double until_s = std::clamp(time_s, 0.0, end_s_);
  const double speed_m_s = drift_m_s2_ * until_s;
  return {0.5 * speed_m_s * until_s + speed_m_s * (time_s - until_s), speed_m_s,
          time_s == until_s ? drift_m_s2_ : 0.0};
}

Motion Drive::at(double time_s) const {
  std::size_t i = 0;
  while (i + 1 < leg_.size() && time_s >= leg_[i + 1].start_s) ++i;
  Motion motion = on_leg(leg_[i], time_s);
  const Motion drifted = drift(time_s);
  motion.position_m += drifted.position_m;
  motion.speed_m_s += drifted.speed_m_s;
  motion.acceleration_m_s2 += drifted.acceleration_m_s2;
  for (const Wander& w : wander_) {
    const double sine = std::sin(w.rate_rad_s * time_s + w.phase_rad);
    const double cosine = std::cos(w.rate_rad_s * time_s + w.phase_rad);
    motion.position_m -= w.amplitude_m_s / w.rate_rad_s * cosine;
    motion.speed_m_s += w.amplitude_m_s * sine;
    motion.acceleration_m_s2 += w.amplitude_m_s * w.rate_rad_s * cosine;
  }
  return motion;
}

}  // namespace roadbalance::sim
