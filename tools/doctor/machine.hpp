#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/gpio/edge_limit.hpp"
#include "tools/doctor/finding.hpp"

namespace roadbalance {

/// Permissions of this process that a node asks for (common/process/realtime.hpp).
struct RealtimeLimits {
  std::int64_t priority = 0;       ///< RLIMIT_RTPRIO
  std::uint64_t locked_bytes = 0;  ///< RLIMIT_MEMLOCK
  bool root = false;
};
inline constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();
Finding realtime(const RealtimeLimits& limits);

/// Whether this machine's clock is kept right, according to the kernel.
/// @param synchronised  by NTP, PTP, GPS ...
Finding wall_clock(bool synchronised);

struct WakeUpMeasurement {
  WakeUps worst;
  std::chrono::milliseconds duration{};
  bool realtime = false;  ///< the threads had real-time priority
};

/// How late threads of the priorities that matter to edges wake up here: each sleeps a millisecond at a time.
/// It measures this time only; so load the machine as it will be, and measure long: the worst is rare.
/// @throws std::system_error if there is no thread to be had
WakeUpMeasurement measure_wake_ups(std::chrono::milliseconds duration);

/// How many encoder edges a second the machine took by GPIO while that was measured.
Finding encoder_edges(const WakeUpMeasurement& measured);

/// @param available_bytes  that programs can still have
Finding memory(double available_bytes);

/// Processors kept at their lowest frequency; nothing if none is.
/// @param sys  where the kernel's tree of devices is, here and below
std::optional<Finding> governor(const std::filesystem::path& sys = "/sys");
/// A battery that empties; nothing if none does.
std::optional<Finding> battery(const std::filesystem::path& sys = "/sys");

/// All of them on this machine.  @param wake_ups  how long those of its threads are measured
std::vector<Finding> examine_machine(std::chrono::milliseconds wake_ups);

}  // namespace roadbalance
