#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "common/frontend/front_end.hpp"

namespace roadbalance::test {

/// Edges of a wheel whose angle is any growing function of time, found by bisection: independent of how the
/// product gets back from edges to angles.
struct PulseTrain {
  std::function<double(double)> angle_rad;  ///< of seconds, growing
  int teeth = 96;
  std::vector<double> pitch_error_rad = {};  ///< [teeth], or empty
  double first_tooth_rad = 0.02;             ///< angle from the zero mark to tooth 0
  double jitter_s = 0.0;
  double lost = 0.0, extra = 0.0;  ///< share of teeth
  std::uint64_t seed = 1;
  std::uint8_t line = 0;

  std::vector<Edge> edges(double from_s, double to_s) const {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    std::vector<Edge> all;
    const double turn = 2.0 * std::numbers::pi, pitch = turn / teeth;
    const auto put = [&](double angle, EdgeKind kind) {
      const double t = time_of(angle, from_s, to_s) + jitter_s * normal(random);
      all.push_back({node_time_from_ns(std::llround(t * 1e9)), line, kind});
    };
    const double begin = angle_rad(from_s), end = angle_rad(to_s);
    for (double mark = std::ceil(begin / turn) * turn; mark < end; mark += turn)
      put(mark, EdgeKind::kZeroMark);
    const auto first = static_cast<std::int64_t>(std::ceil((begin - first_tooth_rad) / pitch)) + 1;
    for (std::int64_t n = first;; ++n) {
      double angle = first_tooth_rad + static_cast<double>(n) * pitch;
      if (!pitch_error_rad.empty())
        angle += pitch_error_rad[static_cast<std::size_t>((n % teeth + teeth) % teeth)];
      if (angle >= end) break;
      if (angle < begin) continue;
      if (uniform(random) >= lost) put(angle, EdgeKind::kTooth);
      if (uniform(random) < extra && angle + pitch < end)
        put(angle + uniform(random) * pitch, EdgeKind::kTooth);
    }
    std::stable_sort(all.begin(), all.end(), [](const Edge& a, const Edge& b) { return a.time < b.time; });
    return all;
  }

  double time_of(double angle, double low_s, double high_s) const {
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low_s + high_s);
      (angle_rad(middle) < angle ? low_s : high_s) = middle;
    }
    return 0.5 * (low_s + high_s);
  }
};

inline std::vector<double> pitch_errors(int teeth, double rms_rad, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, rms_rad);
  std::vector<double> errors(static_cast<std::size_t>(teeth));
  for (double& e : errors) e = normal(random);
  // The mean belongs to the place of tooth 0, once a turn to where the ring sits on its hub.
  double mean = 0.0;
  for (const double e : errors) mean += e / teeth;
  for (double& e : errors) e -= mean;
  return errors;
}

}  // namespace roadbalance::test
