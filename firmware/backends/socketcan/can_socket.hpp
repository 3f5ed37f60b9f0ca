#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/dbc/can_frame.hpp"
#include "common/types/clocks.hpp"
#include "common/types/device_report.hpp"

namespace roadbalance {

struct CanId {
  std::uint32_t id = 0;
  bool extended = false;
  auto operator<=>(const CanId&) const = default;
};

/// The result of one read of a CAN socket.
struct CanReceived {
  enum class Kind {
    kNothing,  ///< empty
    kFrame,
    kTrouble,  ///< the controller reported an error
    kIgnored,  ///< something of no interest; there may be more
    kGone,     ///< the interface went down or away
  };
  Kind kind = Kind::kNothing;
  CanFrame frame;
  MachineTime time{};  ///< when the kernel had the frame, in order
  /// The controller's own stamp, of a clock of its own; nothing if it gives none.
  std::optional<std::int64_t> hardware_ns;
  DeviceCounter trouble = DeviceCounter::kBusErrors;
};

/// Listens on a CAN interface for frames of given identifiers, classic and CAN FD.  It cannot send.
///
/// The kernel stamps frames in CLOCK_REALTIME; of frames that waited while that clock was set, and of those
/// of the first milliseconds, before the kernel begins to stamp, the time of reading counts.  After
/// construction nothing allocates.
class CanSocket {
 public:
  /// @throws std::system_error naming the call and the interface
  CanSocket(const std::string& interface, std::span<const CanId> wanted);
  CanSocket(const CanSocket&) = delete;
  CanSocket& operator=(const CanSocket&) = delete;
  ~CanSocket();

  /// Waits until there is something to receive.
  void wait(std::chrono::milliseconds at_most) const noexcept;

  /// The next.  Never waits.
  CanReceived receive() noexcept;

  /// Frames that the kernel had no room for, since the last call: in this socket, and in the queue before it,
  /// which all identifiers share, so that what was lost there may not have been wanted.
  std::uint64_t take_lost() noexcept;

 private:
  MachineTime machine_time(std::optional<std::int64_t> wall_ns) noexcept;
  void count_lost(std::uint32_t total) noexcept;
  std::uint64_t dropped_before_the_socket() const noexcept;
  void read_clocks() noexcept;

  int descriptor_;
  std::uint32_t lost_total_ = 0;  ///< as the kernel counts: since the socket was opened, wrapping
  std::uint32_t lost_reported_ = 0;
  int dropped_descriptor_ = -1;  ///< the interface's own count
  std::uint64_t dropped_reported_ = 0;
  bool clocks_fresh_ = false;  ///< read since the socket was last found empty
  bool wall_clock_set_ = false;
  MachineTime read_at_{};
  MachineClock::duration machine_minus_wall_{};
  MachineTime newest_{};
};

}  // namespace roadbalance
