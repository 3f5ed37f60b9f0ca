#pragma once

#include <algorithm>
#include <chrono>
#include <utility>

#include "common/types/clocks.hpp"

namespace roadbalance {

/// How long to wait for a block asked for before it is asked for again: twice the round trip, at least
/// `shortest`.
///
/// As in Karn's algorithm only blocks that were asked for once measure the round trip; for others it is not
/// known which question was answered.  While the interval is too short for any such block, the answers that
/// come more than once double it, but not far: in a network that loses much they are no good witness, and one
/// block that is missing must not cost half a second a question.
class AskInterval {
 public:
  explicit AskInterval(WallClock::duration shortest) : shortest_(shortest), interval_(shortest) {}

  WallClock::duration get() const { return interval_; }

  /// A block came `after` the only question for it.
  void answered_once(WallClock::duration after) {
    // Answers that waited at the node behind others are no round trip, and after a pulled cable there are
    // hundreds of them: the shortest of the last one to two runs counts.
    shortest_of_run_ = std::min(shortest_of_run_, after);
    interval_ = std::clamp(2 * std::min(shortest_of_run_, shortest_before_), shortest_, kLongest);
    if (++answers_ % kRun != 0) return;
    shortest_before_ = std::exchange(shortest_of_run_, WallClock::duration::max() / 2);
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

  static constexpr int kRun = 1024;  ///< answers

  const WallClock::duration shortest_;
  WallClock::duration interval_;
  WallClock::duration shortest_of_run_ = WallClock::duration::max() / 2;
  WallClock::duration shortest_before_ = WallClock::duration::max() / 2;  ///< of the run before
  int answers_ = 0;
  int too_soon_ = 0;
};

}  // namespace roadbalance
