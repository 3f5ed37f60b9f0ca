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
  double uncertainty_s = 0;  ///< of node_ns: covers the error in 99.9 % of all cases
  double round_trip_s = 0;
  double residual_s = 0;
  std::int64_t exchanges = 0;
  std::int64_t unanswered = 0;
  std::int64_t breaks = 0;

  bool operator==(const ClockFit&) const = default;
};

}  // namespace roadbalance
