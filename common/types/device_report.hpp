#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

namespace roadbalance {

/// Troubles of a device.  In the order of heartbeat_t.device_counts; new ones go to the end.
enum class DeviceCounter : std::uint8_t {
  kGone,               ///< interface down, cable pulled, chip removed, or no scan of it for a time
  kReturned,           ///< after that
  kBusOff,             ///< the CAN controller took itself off the bus
  kErrorPassive,       ///< the CAN controller may no longer mark errors
  kBusErrors,          ///< other CAN error frames
  kQueueOverflow,      ///< frames that the kernel had no room for
  kFramesRefused,      ///< of wrong length or with a value out of its range
  kStalls,             ///< USB transfers that the board halted
  kShortPackets,       ///< USB packets that ended before their time
  kPacketsRefused,     ///< USB packets with a wrong mark, length or CRC
  kPacketsMissing,     ///< numbers left out in the packet sequence
  kBoardOverrun,       ///< scans that the board lost before it could send them
  kEdgesLost,          ///< times that the device reports missing edges
  kLateEdges,          ///< times that edges came after their scans had gone; not used
  kReadersTooSlow,     ///< what came was dropped because the node did not fetch it; of edges: times
  kControllerOverrun,  ///< the CAN controller had no room for a frame
  kGlitches,           ///< conversions that a board dropped as they came too soon
  kOutOfStep,          ///< two boards, of which this one slipped, were started anew
  kPartnerLate,        ///< scans of the other board that went because this one's did not come
  kClockUnanswered,    ///< the board did not report its clock
  kFaultyTurns,        ///< turns of an encoder without exactly their teeth: flagged
  kCountBroken,     ///< times that the count of teeth on a bus did not go on: no angle until marks place it
  kMarksElsewhere,  ///< zero marks that lay elsewhere among a bus's teeth than those before: flagged
};
inline constexpr std::size_t kDeviceCounters = 23;

/// One of them in words, for people: "was unplugged or went down".
const char* sentence(DeviceCounter counter);
/// And how often: "was unplugged or went down (2 times by now)".
std::string sentence(DeviceCounter counter, std::int64_t times);
/// The same as a key: "gone".
const char* name_of(DeviceCounter counter);

/// One device's count of its troubles since it was opened.  Written by the threads that serve the device,
/// read by any other; never blocks.
class DeviceReport {
 public:
  /// @param device  its URI, e.g. "can:can0"
  explicit DeviceReport(std::string device) : device_(std::move(device)) {}

  void count(DeviceCounter counter, std::int64_t times = 1) noexcept {
    counts_[static_cast<std::size_t>(counter)].fetch_add(times, std::memory_order_relaxed);
  }
  std::int64_t of(DeviceCounter counter) const noexcept {
    return counts_[static_cast<std::size_t>(counter)].load(std::memory_order_relaxed);
  }
  const std::string& device() const noexcept { return device_; }

 private:
  const std::string device_;
  std::array<std::atomic<std::int64_t>, kDeviceCounters> counts_{};
};

}  // namespace roadbalance
