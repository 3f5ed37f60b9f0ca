#pragma once

#include <cstdint>
#include <cstdlib>
#include <utility>

namespace roadbalance {

/// Distinguishes teeth that are missing or too many from teeth whose stamps jitter.
///
/// A stamp that jitters by nearly half a pitch leaves its own tooth without a pulse and is one too many at
/// the next: where stamps jitter so much, the two cancel within two teeth, as a turn with them has exactly
/// its teeth.  Where they do not, each is a fault of the ring or its line, though the count comes out right.
class FaultBalance {
 public:
  struct Faults {
    std::int64_t count = 0;
    std::int64_t since_ns = 0;  ///< when the first of them came
  };
  /// @param number   of the tooth numbered last
  /// @param surplus  pulses that were no tooth less teeth that had no pulse, since the call before
  /// @param jitter   stamps jitter so much that they can leave their tooth
  /// The faults that are certain by now.
  Faults add(std::int64_t time_ns, std::int64_t number, std::int64_t surplus, bool jitter) noexcept {
    Faults known;
    if (!jitter || number - number_ > kReach_teeth) known = close();  // what comes now cancels none of it
    if (surplus == 0) return known;
    if (open_ == 0) {
      since_ns_ = time_ns;
      number_ = number;
    }
    open_ += surplus;
    if (jitter) return known;
    const Faults now = close();
    return known.count > 0 ? Faults{known.count + now.count, known.since_ns} : now;
  }
  void forget() noexcept { open_ = 0; }

 private:
  static constexpr std::int64_t kReach_teeth = 2;

  Faults close() noexcept { return {std::abs(std::exchange(open_, 0)), since_ns_}; }

  std::int64_t open_ = 0, number_ = 0, since_ns_ = 0;
};

}  // namespace roadbalance
