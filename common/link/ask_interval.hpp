#pragma once

#include <algorithm>
#include <chrono>

#include "common/clock/clocks.hpp"

namespace roadbalance {

/// How long to wait for a block asked for before it is asked for again: twice the round trip, at least
/// `shortest`.
///
/// As in Karn's algorithm only blocks that were asked for once tell the round trip; of others nobody knows
/// which question was answered.  While the interval is too short for any such block, the answers that come
/// more than once double it, but not far: in a network that loses much they are no good witness, and one
/// block that is missing must not cost half a second a question.
class AskInterval {
 public:
  explicit AskInterval(WallClock::duration shortest) : shortest_(shortest), interval_(shortest) {}

  WallClock::duration get() const { return interval_; }

  /// A block came `after` the only question for it.
  void answered_once(WallClock::duration after) {
    // Answers that waited at the node behind others are no round trip: what is shorter counts at once.
    const bool is_news = round_trip_.count() == 0 || after < round_trip_;
    round_trip_ = is_news ? after : (31 * round_trip_ + after) / 32;
    interval_ = std::clamp(2 * round_trip_, shortest_, kLongest);
  }
  /// A block came that was asked for again.
  void answered_late() { too_soon_ = std::max(0, too_soon_ - 1); }
  /// It came again: the second question was one too many, or the network doubled it.
  void answered_twice() {
    too_soon_ += 2;
    if (too_soon_ < 16) return;
    too_soon_ = 0;
    interval_ = std::max(interval_, std::min(2 * interval_, kLongestGuess));
  }

 private:
  static constexpr WallClock::duration kLongest = std::chrono::milliseconds(500);
  static constexpr WallClock::duration kLongestGuess = std::chrono::milliseconds(100);

  const WallClock::duration shortest_;
  WallClock::duration interval_;
  WallClock::duration round_trip_{};
  int too_soon_ = 0;
};

}  // namespace roadbalance
