#include "sim/counter_messages.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace roadbalance::sim {

namespace {

constexpr double kFrame_s = 1e-4;

}  // namespace

double counter_code(double teeth_passed, std::int64_t modulus, std::int64_t step) {
  const auto wraps = static_cast<double>(modulus), by = static_cast<double>(step);
  const double shown = by * std::floor(teeth_passed / by);
  return shown - wraps * std::floor(shown / wraps);
}

std::vector<SignalSample> CounterMessages::samples(double from_s, double to_s) const {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<SignalSample> all;
  // Beyond three times its rms a queue on a bus would be another one.
  const auto shake = [&] { return jitter_s * std::clamp(normal(random), -3.0, 3.0); };
  double last_s = from_s - 1.0;
  for (std::int64_t k = 0; from_s + static_cast<double>(k) / rate_hz < to_s; ++k) {
    const double sampled_s = from_s + static_cast<double>(k) / rate_hz;
    // Frames of one identifier do not overtake one another.
    const double stamped_s = std::max(sampled_s + latency_s + shake(), last_s + kFrame_s);
    last_s = stamped_s;
    const bool is_lost = uniform(random) < lost;
    if (is_lost) continue;
    const double teeth_passed = (angle_rad(sampled_s) - first_tooth_rad) / (2.0 * std::numbers::pi) * teeth;
    all.push_back({node_time_from_ns(std::llround(stamped_s * 1e9)), signal,
                   counter_code(teeth_passed - lost_counts(sampled_s), modulus)});
  }
  return all;
}

}  // namespace roadbalance::sim
