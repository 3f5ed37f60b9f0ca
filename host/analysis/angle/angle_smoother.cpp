#include "host/analysis/angle/angle_smoother.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace roadbalance {
namespace {

using State = Eigen::Vector3d;  // position, speed, acceleration; pitches, seconds
using Covariance = Eigen::Matrix3d;

constexpr std::array kBandwidth_hz{3.0, 6.0, 11.0, 18.0, 28.0, 45.0};
constexpr double kGate = 5.0;          // standard deviations
constexpr int kMostPassedOver = 5;     // in a row: more are no outliers
constexpr std::size_t kSettling = 30;  // points whose innovations come from the start, not of the jerk

struct Filtered {
  State predicted, state;
  Covariance predicted_covariance, covariance;
};

/// Density of white jerk at which the smoother passes half at `hz`: 1 / (1 + (f / hz)^6).
double jerk_density(double hz, double noise, double points_per_s) {
  return std::pow(2.0 * std::numbers::pi * hz, 6) * noise / points_per_s;
}

Covariance transition(double dt) {
  Covariance f = Covariance::Identity();
  f(0, 1) = f(1, 2) = dt;
  f(0, 2) = 0.5 * dt * dt;
  return f;
}

/// Integral of white jerk over dt.
Covariance jerk_covariance(double dt, double density) {
  const double d2 = dt * dt, d3 = d2 * dt;
  Covariance q;
  q << d3 * d2 / 20.0, d2 * d2 / 8.0, d3 / 6.0, d2 * d2 / 8.0, d3 / 3.0, d2 / 2.0, d3 / 6.0, d2 / 2.0, dt;
  return q * density;
}

class Filter {
 public:
  Filter(const std::vector<WheelPoint>& points, double noise, double density)
      : points_(points), noise_(noise), density_(density) {
    const WheelPoint &first = points.front(), &last = points.back();
    const double speed = (last.position - first.position) / seconds(last.time_ns - first.time_ns);
    now_.predicted = State(0.0, speed, 0.0);
    now_.predicted_covariance =
        State(1.0, 0.04 * speed * speed + 1.0, 100.0 * speed * speed + 1.0).asDiagonal();
  }

  static double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

  /// Takes point i; returns the logarithm of its likelihood.
  double step(std::size_t i) {
    if (i > 0) predict(seconds(points_[i].time_ns - points_[i - 1].time_ns));
    const double innovation = points_[i].position - points_.front().position - now_.predicted(0);
    const double variance = now_.predicted_covariance(0, 0) + noise_ / points_[i].weight;
    now_.state = now_.predicted;
    now_.covariance = now_.predicted_covariance;
    const double distance_square = innovation * innovation / variance;
    if (distance_square > kGate * kGate && ++passed_over_ <= kMostPassedOver)
      return -0.5 * (kGate * kGate + std::log(variance));
    passed_over_ = 0;
    const State gain = now_.predicted_covariance.col(0) / variance;
    now_.state += gain * innovation;
    now_.covariance -= gain * now_.predicted_covariance.row(0);
    return -0.5 * (std::min(distance_square, kGate * kGate) + std::log(variance));
  }
  const Filtered& now() const { return now_; }

 private:
  void predict(double dt) {
    const Covariance f = transition(dt);
    now_.predicted = f * now_.state;
    now_.predicted_covariance = f * now_.covariance * f.transpose() + jerk_covariance(dt, density_);
  }

  const std::vector<WheelPoint>& points_;
  const double noise_, density_;
  Filtered now_;
  int passed_over_ = 0;
};

double likelihood(const std::vector<WheelPoint>& points, double noise, double density) {
  Filter filter(points, noise, density);
  double sum = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double part = filter.step(i);
    if (i >= std::min(kSettling, points.size() / 2)) sum += part;
  }
  return sum;
}

}  // namespace

bool AngleSmoother::smooth(const std::vector<WheelPoint>& points, double noise) {
  smoothed_.clear();
  if (points.size() < LocalFit::kLeastPoints || !(noise > 0.0)) return false;
  const double span_s = Filter::seconds(points.back().time_ns - points.front().time_ns);
  if (!(span_s > 0.0) || !(points.back().position > points.front().position)) return false;
  double weight = 0.0;
  for (const WheelPoint& point : points) weight += point.weight;
  const auto density = [&](double hz) { return jerk_density(hz, noise, weight / span_s); };

  double best = -std::numeric_limits<double>::infinity();
  for (const double hz : kBandwidth_hz) {
    const double value = likelihood(points, noise, density(hz));
    if (!(value > best)) continue;
    best = value;
    bandwidth_hz_ = hz;
  }
  if (!std::isfinite(best)) return false;

  Filter filter(points, noise, density(bandwidth_hz_));
  std::vector<Filtered> filtered(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    filter.step(i);
    filtered[i] = filter.now();
  }
  smoothed_.resize(points.size());
  State state = filtered.back().state;
  Covariance covariance = filtered.back().covariance;
  for (std::size_t i = points.size(); i-- > 0;) {
    if (i + 1 < points.size()) {
      const Filtered& next = filtered[i + 1];
      const Covariance f = transition(Filter::seconds(points[i + 1].time_ns - points[i].time_ns));
      const Covariance gain = next.predicted_covariance.ldlt().solve(f * filtered[i].covariance).transpose();
      state = filtered[i].state + gain * (state - next.predicted);
      covariance =
          filtered[i].covariance + gain * (covariance - next.predicted_covariance) * gain.transpose();
    }
    smoothed_[i] = {points[i].time_ns, state(0) + points.front().position, state(1), covariance(0, 0)};
  }
  return true;
}

std::size_t AngleSmoother::before(std::int64_t time_ns) const {
  const auto after = std::ranges::upper_bound(smoothed_, time_ns, {}, &Smoothed::time_ns);
  const auto i = static_cast<std::size_t>(after - smoothed_.begin());
  return std::clamp<std::size_t>(i, 1, smoothed_.size() - 1) - 1;
}

double AngleSmoother::position(std::int64_t time_ns) const {
  const std::size_t i = before(time_ns);
  const Smoothed &a = smoothed_[i], &b = smoothed_[i + 1];
  const double step_s = Filter::seconds(b.time_ns - a.time_ns);
  const double x = Filter::seconds(time_ns - a.time_ns) / step_s;
  const double way = b.position - a.position, from = a.speed_per_s * step_s, to = b.speed_per_s * step_s;
  return a.position + x * (from + x * (3.0 * way - 2.0 * from - to + x * (from + to - 2.0 * way)));
}

double AngleSmoother::sigma(std::int64_t time_ns) const {
  const std::size_t i = before(time_ns);
  return std::sqrt(std::max(smoothed_[i].variance, smoothed_[i + 1].variance));
}

}  // namespace roadbalance
