#include "common/clock/offset_line.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace roadbalance {
namespace {

constexpr double kHuber = 2.0;
constexpr int kPasses = 3;
constexpr double kStampError_s = 1e-6;
constexpr double kShareOfShortest = 1.0 / 8.0;
constexpr double kDriftWander = 0.02e-6;
constexpr double kAgeing = 0.5e-6;

double seconds(std::int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

}  // namespace

struct OffsetLine::Point {
  double t, y, sigma;  // seconds since the reference, offset beyond the reference's, seconds
  double huber = 1.0;

  double weight() const { return huber / (sigma * sigma); }
};

OffsetLine::OffsetLine(std::span<const ClockExchange> exchanges, std::int64_t host_ns,
                       const DriftPrior& prior)
    : reference_ns_(exchanges.back().middle_ns()), reference_offset_ns_(exchanges.back().offset_ns()) {
  std::int64_t shortest_ns = exchanges.front().round_trip_ns();
  for (const auto& e : exchanges) shortest_ns = std::min(shortest_ns, e.round_trip_ns());
  // Stamps of two clocks that are read apart may make a round trip come out negative by their reading errors.
  shortest_s_ = std::max(seconds(shortest_ns), 0.0);
  std::vector<Point> points;
  for (const auto& e : exchanges)
    points.push_back({seconds(e.middle_ns() - reference_ns_), seconds(e.offset_ns() - reference_offset_ns_),
                      kStampError_s + 0.5 * seconds(e.round_trip_ns() - shortest_ns) +
                          kShareOfShortest * shortest_s_ +
                          kDriftWander * std::abs(seconds(e.middle_ns() - host_ns))});
  for (int pass = 0; pass < kPasses; ++pass) {
    solve(points, prior);
    if (pass + 1 == kPasses) break;
    for (auto& p : points) {
      const double off = std::abs(p.y - offset_s_ - drift_ * p.t) / p.sigma;
      p.huber = off <= kHuber ? 1.0 : kHuber / off;
    }
  }
}

void OffsetLine::solve(std::span<const Point> points, const DriftPrior& prior) {
  double w1 = 0, wt = 0, wy = 0, wtt = 1.0 / (prior.sigma * prior.sigma), wty = prior.drift * wtt;
  for (const auto& p : points) {
    const double w = p.weight();
    w1 += w;
    wt += w * p.t;
    wy += w * p.y;
    wtt += w * p.t * p.t;
    wty += w * p.t * p.y;
  }
  const double determinant = w1 * wtt - wt * wt;
  offset_s_ = (wtt * wy - wt * wty) / determinant;
  drift_ = (w1 * wty - wt * wy) / determinant;

  double squares = 0;
  for (const auto& p : points) {
    const double r = p.y - offset_s_ - drift_ * p.t;
    squares += p.weight() * r * r;
  }
  residual_s_ = std::sqrt(squares / w1);
  // Points that scatter more than their sigmas allow make the line worse than the sigmas promise.
  const double scatter = std::max(1.0, squares / static_cast<double>(points.size()));
  variance_offset_ = scatter * wtt / determinant;
  covariance_ = -scatter * wt / determinant;
  variance_drift_ = scatter * w1 / determinant;
}

std::int64_t OffsetLine::node_time_ns(std::int64_t host_ns) const {
  const double offset_s = offset_s_ + drift_ * seconds(host_ns - reference_ns_);
  return host_ns + reference_offset_ns_ + std::llround(1e9 * offset_s);
}

double OffsetLine::drift_sigma() const {
  return std::sqrt(variance_drift_);
}

double OffsetLine::uncertainty_s(std::int64_t host_ns, double age_s) const {
  const double t = seconds(host_ns - reference_ns_);
  const double variance = variance_offset_ + 2.0 * covariance_ * t + variance_drift_ * t * t;
  return 0.5 * shortest_s_ + 2.0 * residual_s_ + kAgeing * age_s + 2.0 * std::sqrt(std::max(variance, 0.0));
}

}  // namespace roadbalance
