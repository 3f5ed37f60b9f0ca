#include "common/angle/counter_unwrap.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace roadbalance {

CounterUnwrap::CounterUnwrap(const CounterForm& form) : form_(form) {
  if (form.modulus < 2) throw std::invalid_argument("pulse counter: modulus must be at least 2");
  if (form.step < 1) throw std::invalid_argument("pulse counter: step must be at least 1");
  if (!(form.highest_rate_hz > 0.0 && form.highest_change_hz_s > 0.0 && form.jitter_s >= 0.0))
    throw std::invalid_argument("pulse counter: limits of rate and its change must be positive");
}

void CounterUnwrap::begin_run(std::int64_t time_ns, std::int64_t code) noexcept {
  time_ns_ = time_ns;
  code_ = code;
  count_ = 0;
  before_.reset();
  ++run_;
}

RateBounds CounterUnwrap::possible(double elapsed_s, std::optional<RateBounds> known) const noexcept {
  RateBounds bounds{.low_hz = 0.0, .high_hz = form_.highest_rate_hz};
  const auto narrow = [&](const RateBounds& by, double change_hz) {
    bounds.low_hz = std::max(bounds.low_hz, by.low_hz - change_hz);
    bounds.high_hz = std::min(bounds.high_hz, by.high_hz + change_hz);
  };
  if (before_) narrow(*before_, form_.highest_change_hz_s * elapsed_s);
  if (known) narrow(*known, 0.0);
  return bounds;
}

CounterUnwrap::Outcome CounterUnwrap::take(std::int64_t time_ns, std::int64_t code, bool valid,
                                           std::optional<RateBounds> known) noexcept {
  if (!valid || code == form_.invalid_code || code < 0 || code >= form_.modulus) {
    ++counters_.invalid;
    return Outcome::kInvalid;
  }
  if (run_ == 0) {
    begin_run(time_ns, code);
    return Outcome::kFirst;
  }
  if (time_ns <= time_ns_) {
    ++counters_.out_of_order;
    return Outcome::kOutOfOrder;
  }
  const double elapsed_s = 1e-9 * static_cast<double>(time_ns - time_ns_);
  const RateBounds rate = possible(elapsed_s, known);
  // Each count was rounded down to a step, and the two messages are of different age.
  const auto step = static_cast<double>(form_.step);
  const double least = rate.low_hz * std::max(0.0, elapsed_s - form_.jitter_s) - step;
  const double most = rate.high_hz * (elapsed_s + form_.jitter_s) + step;

  const auto modulus = static_cast<double>(form_.modulus);
  const std::int64_t moved = (code - code_ + form_.modulus) % form_.modulus;
  const auto first = std::max(0.0, std::ceil((least - static_cast<double>(moved)) / modulus));
  const auto last = std::floor((most - static_cast<double>(moved)) / modulus);
  if (!(first == last)) {
    const bool none = !(first <= last);
    ++(none ? counters_.implausible : counters_.ambiguous);
    begin_run(time_ns, code);
    return none ? Outcome::kImplausible : Outcome::kAmbiguous;
  }
  const std::int64_t counts = moved + static_cast<std::int64_t>(first) * form_.modulus;
  counters_.wraps += (code_ + counts) / form_.modulus;
  ++counters_.joined;
  count_ += counts;
  const double mean_hz = static_cast<double>(counts) / elapsed_s;
  const double doubt_hz =
      (step + mean_hz * form_.jitter_s) / elapsed_s + form_.highest_change_hz_s * elapsed_s;
  before_ = RateBounds{.low_hz = mean_hz - doubt_hz, .high_hz = mean_hz + doubt_hz};
  time_ns_ = time_ns;
  code_ = code;
  return Outcome::kJoined;
}

}  // namespace roadbalance
