#pragma once

#include <cstdint>
#include <optional>

#include "common/config/counter_form.hpp"

namespace roadbalance {

/// The counter's rate at the time, as other messages show it.
struct RateBounds {
  double low_hz = 0.0;
  double high_hz = 0.0;
};

/// From codes that wrap to a count that does not.
///
/// Between two messages the counter has moved by d + k modulus, k >= 0: it may have wrapped unseen while
/// messages were lost.  The rates that the wheel can have had, by its highest rate, by its rate before, and
/// by the car's speed if it is known, leave at most one k, or the messages are not joined: `run` grows by one
/// and the count begins at 0 again.  Nothing is claimed across such a break.  A counter does not show the
/// wheel's direction; all counts are taken for forward ones.
class CounterUnwrap {
 public:
  enum class Outcome {
    kFirst,        ///< begins the first run
    kJoined,       ///< goes on from the message before
    kInvalid,      ///< carries no count; not used
    kOutOfOrder,   ///< not younger than the one before; not used
    kAmbiguous,    ///< more than one number of wraps is possible; begins a run
    kImplausible,  ///< no number of wraps is possible, e.g. the counter was reset; begins a run
  };
  struct Counters {
    std::int64_t joined = 0, invalid = 0, out_of_order = 0, ambiguous = 0, implausible = 0;
    std::int64_t wraps = 0;  ///< of the counter, seen or not
  };

  /// @throws std::invalid_argument if modulus < 2, step < 1 or a limit is not positive
  explicit CounterUnwrap(const CounterForm& form);

  /// @param valid  the message's own validity bit; true if it has none
  /// @param known  the rate by the car's speed since the message before; nothing: it is not known
  Outcome take(std::int64_t time_ns, std::int64_t code, bool valid = true,
               std::optional<RateBounds> known = std::nullopt) noexcept;

  std::int64_t count() const noexcept { return count_; }  ///< since the run began
  std::int64_t run() const noexcept { return run_; }      ///< 0: none yet
  const Counters& counters() const noexcept { return counters_; }

 private:
  RateBounds possible(double elapsed_s, std::optional<RateBounds> known) const noexcept;
  void begin_run(std::int64_t time_ns, std::int64_t code) noexcept;

  CounterForm form_;
  std::int64_t time_ns_ = 0, code_ = 0, count_ = 0, run_ = 0;
  std::optional<RateBounds> before_;  ///< over the interval before
  Counters counters_;
};

}  // namespace roadbalance
