#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>

#include "common/types/exchange.hpp"

namespace roadbalance::test {

/// A node's oscillator and the network to it, drawn by seed: an offset of years, a drift of up to 50 ppm that
/// a temperature swings by 1 ppm and that walks by 0.01 ppm a root second; ways of different length; queues
/// of exponential delay; congestion of up to 20 ms on one way, in bursts; losses.
class SimulatedClocks {
 public:
  explicit SimulatedClocks(std::uint64_t seed) : random_(seed) {
    offset_s_ = uniform(-1e5, 1e5);
    drift_ = uniform(-50e-6, 50e-6);
    phase_ = uniform(0.0, 6.28);
    way_s_[0] = uniform(5e-6, 200e-6);
    way_s_[1] = uniform(5e-6, 200e-6);
    queue_s_ = uniform(1e-6, 100e-6);
    loss_ = uniform(0.0, 0.3);
  }

  /// Node clock minus host clock at the present instant of the host clock.
  double offset_s() const { return offset_s_; }
  double now_s() const { return now_s_; }
  std::int64_t node_ns() const { return to_ns(now_s_ + offset_s_); }
  std::int64_t host_ns() const { return to_ns(now_s_); }

  /// Lets time pass.  The clock's rate is held for a millisecond at a time.
  void pass(double seconds) {
    for (const double end_s = now_s_ + seconds; now_s_ < end_s;) {
      const double step_s = std::min(1e-3, end_s - now_s_);
      drift_ += 0.01e-6 * std::sqrt(step_s) * normal_(random_);
      offset_s_ += step_s * (drift_ + 1e-6 * std::sin(now_s_ / 50.0 + phase_));
      now_s_ += step_s;
      if (now_s_ > congested_until_s_ && uniform(0.0, 1.0) < step_s / 20.0) {  // every 20 s
        congested_until_s_ = now_s_ + uniform(0.5, 5.0);
        congested_way_ = uniform(0.0, 1.0) < 0.5 ? 0 : 1;
      }
    }
  }

  void jump(double seconds) { offset_s_ += seconds; }

  /// A question asked now; time passes until its answer is back.  Nothing if either was lost.
  std::optional<ClockExchange> exchange(std::int64_t number) {
    ClockExchange e{.node = 1, .epoch = 1, .number = number};
    e.asked_ns = host_ns();
    pass(delay_s(0));
    e.received_ns = node_ns();
    pass(uniform(1e-6, 30e-6));
    e.answered_ns = node_ns();
    pass(delay_s(1));
    e.heard_ns = host_ns();
    if (uniform(0.0, 1.0) < loss_) return std::nullopt;
    return e;
  }

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

 private:
  static std::int64_t to_ns(double seconds) { return std::llround(seconds * 1e9); }

  double delay_s(int way) {
    double delay = way_s_[way] + std::exponential_distribution<double>(1.0 / queue_s_)(random_);
    if (now_s_ < congested_until_s_ && way == congested_way_) delay += uniform(1e-3, 20e-3);
    return delay;
  }

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  double now_s_ = 1000.0, offset_s_, drift_, phase_, queue_s_, loss_;
  double way_s_[2];
  double congested_until_s_ = 0.0;
  int congested_way_ = 0;
};

}  // namespace roadbalance::test
