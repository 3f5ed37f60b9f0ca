#include "host/analysis/angle/recorded_speed.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {

RecordedSpeed::RecordedSpeed(std::span<const SignalSample> speeds, double radius_m) {
  for (const SignalSample& sample : speeds) {
    Point point{to_ns(sample.time), sample.value / radius_m, 0.0, 1};
    if (!points_.empty()) {
      const Point& last = points_.back();
      const std::int64_t apart_ns = point.time_ns - last.time_ns;
      if (apart_ns <= 0) continue;
      point.run = last.run + (apart_ns > kLongestSilence_ns ? 1 : 0);
      point.turned_rad =
          last.turned_rad + 0.5e-9 * static_cast<double>(apart_ns) * (last.speed_rad_s + point.speed_rad_s);
    }
    points_.push_back(point);
  }
}

bool RecordedSpeed::turned(NodeTime first, double step_ns, std::span<double> angle_rad) const {
  if (angle_rad.empty() || points_.size() < 2) return false;
  auto after = std::ranges::upper_bound(points_, to_ns(first), {}, &Point::time_ns);
  if (after == points_.begin()) return false;
  const std::int64_t run = (after - 1)->run;
  for (std::size_t i = 0; i < angle_rad.size(); ++i) {
    const std::int64_t time_ns = to_ns(first) + std::llround(static_cast<double>(i) * step_ns);
    while (after != points_.end() && after->time_ns <= time_ns) ++after;
    if (after == points_.end() || after->run != run) return false;
    const Point &a = *(after - 1), &b = *after;
    const double since_s = 1e-9 * static_cast<double>(time_ns - a.time_ns);
    const double apart_s = 1e-9 * static_cast<double>(b.time_ns - a.time_ns);
    angle_rad[i] =
        a.turned_rad + since_s * (a.speed_rad_s + 0.5 * since_s / apart_s * (b.speed_rad_s - a.speed_rad_s));
  }
  return true;
}

}  // namespace roadbalance
