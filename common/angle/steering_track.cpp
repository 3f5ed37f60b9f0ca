#include "common/angle/steering_track.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace roadbalance {

SteeringTrack::SteeringTrack(std::size_t kept) : points_(kept) {
  if (kept < 2) throw std::invalid_argument("steering angle: at least two messages must be kept");
}

void SteeringTrack::add(std::int64_t time_ns, double angle_rad) noexcept {
  if (!std::isfinite(angle_rad) || (taken_ > 0 && time_ns <= point(taken_ - 1).time_ns)) return;
  points_[taken_++ % points_.size()] = {time_ns, angle_rad};
}

/// How long the n-th message stands for the angle: by the mean period of the few before it.
std::int64_t SteeringTrack::worth_ns(std::size_t n) const noexcept {
  constexpr std::size_t kMean = 8;
  const std::size_t oldest = taken_ - std::min(taken_, points_.size());
  const std::size_t periods = std::min(n - oldest, kMean);
  if (periods == 0) return kLongest_ns;
  const std::int64_t passed_ns = point(n).time_ns - point(n - periods).time_ns;
  return std::min(kLongest_ns, kPeriods * passed_ns / static_cast<std::int64_t>(periods));
}

std::optional<double> SteeringTrack::at(std::int64_t time_ns) const noexcept {
  std::size_t first = taken_ - std::min(taken_, points_.size()), end = taken_;
  while (first < end) {  // the first message after the instant
    const std::size_t middle = first + (end - first) / 2;
    if (point(middle).time_ns <= time_ns)
      first = middle + 1;
    else
      end = middle;
  }
  if (first == taken_ - std::min(taken_, points_.size())) return std::nullopt;
  const Point& before = point(first - 1);
  const std::int64_t longest_ns = worth_ns(first - 1);
  if (first < taken_ && point(first).time_ns - before.time_ns <= longest_ns) {
    const Point& after = point(first);
    const double part =
        static_cast<double>(time_ns - before.time_ns) / static_cast<double>(after.time_ns - before.time_ns);
    return before.angle_rad + part * (after.angle_rad - before.angle_rad);
  }
  if (time_ns - before.time_ns > longest_ns) return std::nullopt;
  return before.angle_rad;
}

bool SteeringTrack::is_awaited(std::int64_t time_ns) const noexcept {
  if (taken_ == 0) return false;
  const std::int64_t newest_ns = point(taken_ - 1).time_ns;
  return newest_ns < time_ns && time_ns - newest_ns <= kSilence_ns;
}

bool SteeringTrack::take_out(double ratio, std::int64_t first_ns, double step_ns,
                             std::span<double> angle_rad) const noexcept {
  bool all = true;
  double last_rad = taken_ > 0 ? point(taken_ - 1).angle_rad : 0.0;
  for (std::size_t i = 0; i < angle_rad.size(); ++i) {
    const auto given = at(first_ns + std::llround(static_cast<double>(i) * step_ns));
    if (given) last_rad = *given;
    all = all && given;
    angle_rad[i] -= ratio * last_rad;
  }
  return all;
}

}  // namespace roadbalance
