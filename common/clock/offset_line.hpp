#pragma once

#include <cstdint>
#include <span>

#include "common/types/exchange.hpp"

namespace roadbalance {

/// The drift as known before the exchanges are asked.
struct DriftPrior {
  double drift = 0.0;
  double sigma = 200e-6;  ///< two crystals of 100 ppm each
};

/// A robust line through the offsets of exchanges: node clock - host clock = offset + drift (t - t0).
///
/// Weighted least squares with Huber's weights (k = 2), three passes.  An exchange weighs by
///
///     sigma_i = 1 us + (d_i - d_min) / 2 + d_min / 8 + 0.02e-6 |t_i - t|
///
/// with d_i its round trip: the excess of a round trip over the shortest one can lie on one way; the shortest
/// one varies, too; and no oscillator keeps its drift.  `prior` gives a line through few exchanges a slope.
class OffsetLine {
 public:
  /// @param exchanges  plausible; at least one
  /// @param host_ns    the instant t that the line is to be best at
  OffsetLine(std::span<const ClockExchange> exchanges, std::int64_t host_ns, const DriftPrior& prior);

  /// Node clock at an instant of the host clock.
  std::int64_t node_time_ns(std::int64_t host_ns) const;

  double drift() const { return drift_; }
  double drift_sigma() const;
  double round_trip_s() const { return shortest_s_; }
  double residual_s() const { return residual_s_; }

  /// Covers the error of node_time_ns(host_ns) in 99.9 % of all cases:
  ///
  ///     u = d_min / 2 + 2 residual + 0.5e-6 age + 2 sigma(t)
  ///
  /// No number of exchanges shows more than d_min / 2: one way may take longer than the other.  sigma(t) is
  /// the line's own standard deviation at t: without it a line through a few exchanges, whose drift is hardly
  /// known, claims more than it can hold a second later (clock_model_test then covers 99.73 %).
  /// @param age_s  of the newest exchange at host_ns
  double uncertainty_s(std::int64_t host_ns, double age_s) const;

 private:
  struct Point;
  void solve(std::span<const Point> points, const DriftPrior& prior);

  std::int64_t reference_ns_;         ///< host clock
  std::int64_t reference_offset_ns_;  ///< node clock - host clock there, roughly
  double offset_s_ = 0.0;             ///< beyond reference_offset_ns_
  double drift_ = 0.0;
  double variance_offset_ = 0.0, covariance_ = 0.0, variance_drift_ = 0.0;
  double shortest_s_ = 0.0;
  double residual_s_ = 0.0;
};

}  // namespace roadbalance
