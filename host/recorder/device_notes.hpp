#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/types/clocks.hpp"
#include "common/types/device_report.hpp"

namespace roadbalance {

/// Something about a node's devices for the record: a note of kind kDevice.
struct DeviceNote {
  std::int32_t node = 0;
  DeviceCounter counter{};
  std::string text;  ///< "was unplugged or went down (2 times by now)"
};

/// The counters of one node epoch's devices, from its heartbeats -> notes, one a second at most of each
/// counter; then of all that came meanwhile.  A pure state machine.
class DeviceNotes {
 public:
  static constexpr std::chrono::seconds kPeriod{1};

  /// @param counts  of a heartbeat: [DeviceCounter], over the node's devices
  void take(std::span<const std::int64_t, kDeviceCounters> counts);
  /// Adds the notes that are due.
  void due(std::int32_t node, WallTime now, std::vector<DeviceNote>& notes);
  /// No more heartbeats come: adds the notes that were held back.
  void finish(std::int32_t node, std::vector<DeviceNote>& notes);

 private:
  struct Counter {
    std::int64_t heard = 0, noted = 0;
    WallTime noted_at{};  ///< if something was
  };
  void note(std::int32_t node, std::size_t counter, std::vector<DeviceNote>& notes);

  std::array<Counter, kDeviceCounters> counter_{};
};

}  // namespace roadbalance
