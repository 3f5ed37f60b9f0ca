#include "firmware/readout_clock.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {
namespace {

constexpr double kFollowing = 1e-3;      // of the time that passes
constexpr double kMostLateness_s = 1.0;  // beside the line: more is a jump of the clock
constexpr double kMostSlope = 1e-3;      // of a converter against its nominal rate

}  // namespace

ReadoutClock::ReadoutClock(double rate_hz) : period_s_(1.0 / rate_hz) {}

void ReadoutClock::restart(const Scan& scan) noexcept {
  started_ = true;
  first_index_ = scan.index;
  first_time_ = scan.time;
  points_ = 0;
  bin_ = {0.0, 0.0};
  bin_end_s_ = kBin_s;
  late_s_ = slope_ = shown_s_ = shown_at_s_ = 0.0;
}

void ReadoutClock::correct(std::span<Scan> scans) noexcept {
  for (Scan& scan : scans) {
    if (!started_ || scan.after_absence) restart(scan);
    double at_s = static_cast<double>(scan.index - first_index_) * period_s_;
    double late_s = to_seconds(scan.time - first_time_) - at_s;
    if (at_s < shown_at_s_ || std::abs(late_s - line_s(at_s)) > kMostLateness_s) {
      restart(scan);
      at_s = late_s = 0.0;
    }
    add({at_s, late_s});
    const double most = kFollowing * (at_s - shown_at_s_);
    shown_s_ += std::clamp(line_s(at_s) - shown_s_, -most, most);
    shown_at_s_ = at_s;
    scan.time = first_time_ + NodeClock::duration(std::llround(1e9 * (at_s + shown_s_)));
  }
}

void ReadoutClock::add(Point point) noexcept {
  if (point.at_s >= bin_end_s_) {
    if (points_ == kPoints) {
      std::copy(point_.begin() + 1, point_.end(), point_.begin());
      --points_;
    }
    point_[points_++] = bin_;
    bin_ = point;
    bin_end_s_ = point.at_s + kBin_s;
    fit();
    return;
  }
  if (point.late_s < bin_.late_s) bin_ = point;
  // Before the first fit, and whenever a stamp comes below the line: nothing is read before it was converted.
  if (point.late_s < line_s(point.at_s)) late_s_ += point.late_s - line_s(point.at_s);
}

void ReadoutClock::fit() noexcept {
  if (points_ < 3) return;
  // The lower hull, left to right (A. Andrew's chain).
  std::array<Point, kPoints> hull;
  std::size_t n = 0;
  for (std::size_t i = 0; i < points_; ++i) {
    const Point p = point_[i];
    const auto right_turn = [&](const Point& a, const Point& b) {
      return (b.late_s - a.late_s) * (p.at_s - b.at_s) >= (p.late_s - b.late_s) * (b.at_s - a.at_s);
    };
    while (n >= 2 && right_turn(hull[n - 2], hull[n - 1])) --n;
    hull[n++] = p;
  }
  double middle_s = 0.0;
  for (std::size_t i = 0; i < points_; ++i) middle_s += point_[i].at_s / static_cast<double>(points_);
  std::size_t edge = 0;
  while (edge + 2 < n && hull[edge + 1].at_s < middle_s) ++edge;
  const Point a = hull[edge], b = hull[edge + 1];
  slope_ = std::clamp((b.late_s - a.late_s) / (b.at_s - a.at_s), -kMostSlope, kMostSlope);
  late_s_ = a.late_s - slope_ * a.at_s;
}

}  // namespace roadbalance
