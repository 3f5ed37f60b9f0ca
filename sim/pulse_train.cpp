#include "sim/pulse_train.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "common/types/angle_units.hpp"

namespace roadbalance::sim {
namespace {

constexpr double kStep_s = 1e-4;

struct Point {
  double time_s, angle_rad;
};

/// Instant between two at which the angle passes `target`: false position with the Illinois correction, which
/// keeps the bracket.
double passing(const std::function<double(double)>& angle, Point a, Point b, double target) {
  double left = a.angle_rad - target, right = b.angle_rad - target;
  for (int i = 0; i < 50 && right != left && std::abs(b.time_s - a.time_s) > 1e-12; ++i) {
    const double time_s = b.time_s - right * (b.time_s - a.time_s) / (right - left);
    const double here = angle(time_s) - target;
    if (std::abs(here) < 1e-13) return time_s;
    if ((here > 0.0) == (right > 0.0)) {
      left *= 0.5;
    } else {
      a = b;
      left = right;
    }
    b.time_s = time_s;
    right = here;
  }
  return b.time_s;
}

void make_zero_mean(std::vector<double>& errors) {
  double mean = 0.0;
  for (const double e : errors) mean += e / static_cast<double>(errors.size());
  for (double& e : errors) e -= mean;
}

}  // namespace

double PulseTrain::tooth_rad(std::int64_t n) const {
  double angle = first_tooth_rad + kTurn * static_cast<double>(n) / teeth;
  if (!pitch_error_rad.empty())
    angle += pitch_error_rad[static_cast<std::size_t>((n % teeth + teeth) % teeth)];
  return angle;
}

std::vector<Edge> PulseTrain::edges(double from_s, double to_s) const {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<Edge> all;
  const auto put = [&](double time_s, EdgeKind kind) {
    all.push_back({node_time_from_ns(std::llround((time_s + jitter_s * normal(random)) * 1e9)), line, kind});
  };

  Point from{from_s, angle_rad(from_s)};
  std::int64_t next = std::llround((from.angle_rad - first_tooth_rad) / kTurn * teeth) - 2;
  while (tooth_rad(next) <= from.angle_rad) ++next;  // the first tooth above the angle
  auto mark = static_cast<std::int64_t>(std::floor(from.angle_rad / kTurn)) + 1;
  double last_s = from_s;

  const auto pass_tooth = [&](const Point& to, std::int64_t n, bool forward) {
    const double time_s = passing(angle_rad, from, to, tooth_rad(n));
    const EdgeKind kind = !forward && second_track ? EdgeKind::kToothBackward : EdgeKind::kTooth;
    if (uniform(random) >= lost) put(time_s, kind);
    if (uniform(random) < extra && time_s > last_s) put(time_s - uniform(random) * (time_s - last_s), kind);
    last_s = time_s;
  };
  const auto pass_mark = [&](const Point& to, std::int64_t n) {
    put(passing(angle_rad, from, to, kTurn * static_cast<double>(n)), EdgeKind::kZeroMark);
  };
  const auto steps = static_cast<std::int64_t>(std::ceil((to_s - from_s) / kStep_s));
  for (std::int64_t i = 1; i <= steps; ++i) {
    const double time_s = std::min(to_s, from_s + static_cast<double>(i) * kStep_s);
    const Point to{time_s, angle_rad(time_s)};
    while (tooth_rad(next) <= to.angle_rad) pass_tooth(to, next++, true);
    while (tooth_rad(next - 1) > to.angle_rad) pass_tooth(to, --next, false);
    while (kTurn * static_cast<double>(mark) <= to.angle_rad) pass_mark(to, mark++);
    while (kTurn * static_cast<double>(mark - 1) > to.angle_rad) pass_mark(to, --mark);
    from = to;
  }
  std::stable_sort(all.begin(), all.end(), [](const Edge& a, const Edge& b) { return a.time < b.time; });
  return all;
}

std::vector<double> pitch_errors(int teeth, double rms_rad, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, rms_rad);
  std::vector<double> errors(static_cast<std::size_t>(teeth));
  for (double& e : errors) e = rms_rad > 0.0 ? normal(random) : 0.0;
  make_zero_mean(errors);
  return errors;
}

std::vector<double> with_eccentricity(std::vector<double> errors, double amplitude_rad, double phase_rad) {
  const double pitch = kTurn / static_cast<double>(errors.size());
  for (std::size_t n = 0; n < errors.size(); ++n)
    errors[n] += amplitude_rad * std::sin(pitch * static_cast<double>(n) + phase_rad);
  return errors;
}

std::vector<double> with_joint(std::vector<double> errors, double share) {
  // The other pitches are too narrow by as much as the joint is too wide.
  const auto teeth = static_cast<double>(errors.size());
  const double pitch = kTurn / teeth;
  for (std::size_t n = 0; n < errors.size(); ++n)
    errors[n] -= share * pitch * static_cast<double>(n) / (teeth - 1.0);
  make_zero_mean(errors);
  return errors;
}

}  // namespace roadbalance::sim
