#pragma once

#include <cstdint>

namespace roadbalance {

/// One question for the time and its answer: the four instants of NTP (D. Mills, RFC 5905, section 8).
struct ClockExchange {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t number = 0;
  std::int64_t asked_ns = 0;        ///< host clock
  std::int64_t received_ns = 0;     ///< node clock
  std::int64_t answered_ns = 0;     ///< node clock
  std::int64_t heard_ns = 0;        ///< host clock
  std::uint32_t kernel_stamps = 0;  ///< bit k: the k-th instant above is the kernel's own stamp

  /// True if no clock ran backwards and no answer took a second: the functions below are for such exchanges
  /// only.
  bool is_plausible() const {
    constexpr std::int64_t kLongest_ns = 1'000'000'000;
    const auto short_time = [](std::int64_t ns) { return 0 <= ns && ns <= kLongest_ns; };
    return short_time(heard_ns - asked_ns) && short_time(answered_ns - received_ns);
  }
  /// Node clock minus host clock, if both ways took equally long; wrong by half the round trip at most.
  std::int64_t offset_ns() const { return (received_ns - asked_ns) / 2 + (answered_ns - heard_ns) / 2; }
  /// Time under way, there and back.
  std::int64_t round_trip_ns() const { return (heard_ns - asked_ns) - (answered_ns - received_ns); }
  /// The instant of the host clock that offset_ns() is true of.
  std::int64_t middle_ns() const { return asked_ns + (heard_ns - asked_ns) / 2; }

  bool operator==(const ClockExchange&) const = default;
};

enum class ClockState : std::int32_t {
  kAcquire = 0,  ///< too few exchanges yet
  kLocked = 1,
  kHoldover = 2,  ///< no exchange for a while: the uncertainty grows
};

/// How a node's clock stands to the host's:
/// node time = node_ns + (host time - host_ns) (1 + drift).
struct ClockFit {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t number = 0;
  ClockState state = ClockState::kAcquire;
  std::int64_t host_ns = 0;
  std::int64_t node_ns = 0;
  double drift = 0;          ///< pure number
  double uncertainty_s = 0;  ///< until ClockModel::kFitLife_ns later; covers the error in 99.9 %
  double round_trip_s = 0;
  double residual_s = 0;
  std::int64_t exchanges = 0;
  std::int64_t unanswered = 0;
  std::int64_t breaks = 0;

  /// Otherwise only the counts mean anything.
  bool is_known() const { return state != ClockState::kAcquire; }
  /// The host's instant of a node's instant.
  std::int64_t host_time_ns(std::int64_t node_time_ns) const {
    const double since = static_cast<double>(node_time_ns - node_ns) / (1.0 + drift);
    return host_ns + static_cast<std::int64_t>(since < 0 ? since - 0.5 : since + 0.5);
  }

  bool operator==(const ClockFit&) const = default;
};

}  // namespace roadbalance
