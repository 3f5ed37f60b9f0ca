#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <semaphore>
#include <string>
#include <thread>
#include <vector>

#include "common/config/node_wiring.hpp"
#include "common/frontend/front_end.hpp"
#include "common/frontend/lasting_reason.hpp"
#include "firmware/backends/socketcan/can_link.hpp"
#include "firmware/backends/socketcan/can_socket.hpp"
#include "firmware/backends/socketcan/hardware_stamps.hpp"
#include "firmware/board/interrupt_ring.hpp"

namespace roadbalance {

/// A frame that came, with its stamp on the machine's time line.
struct CanArrival {
  CanFrame frame;
  NodeTime time{};
  bool after_absence = false;  ///< the first since the interface was gone
};

/// A real-time thread that fetches the frames of an interface as they come and keeps them for one reader.
///
/// An interface that goes down or away is asked for by its name every 50 ms and heard again once it is up in
/// its role; in another one it stays gone, and why is said when that lasts.  Troubles are counted in the
/// report.  Neither side allocates after construction while the interface is there.
class CanIntake {
 public:
  using Warn = std::function<void(const std::string&)>;

  /// @param wanted  identifiers; at least one
  /// @param warn    hears, from the thread, what the system refuses of its real-time priority, and why an
  ///                interface that went cannot be heard again
  /// @throws ConfigError if there is no such interface, or not up, or not as needed; std::system_error
  CanIntake(const std::string& interface, CanNeed need, std::vector<CanId> wanted, Warn warn);
  CanIntake(const CanIntake&) = delete;
  CanIntake& operator=(const CanIntake&) = delete;
  ~CanIntake();

  /// The reader's: how many frames wait; more may come.
  std::size_t size() const { return ring_->size(); }
  /// The k-th oldest, k < size().
  const CanArrival& operator[](std::size_t k) const { return (*ring_)[k]; }
  void drop(std::size_t count) { ring_->drop(count); }
  /// Until a frame is there.
  void wait(std::chrono::milliseconds at_most) noexcept;

  /// Every frame stamped before is in the ring or was lost; of an interface that is gone: the present.
  NodeTime complete_until() const noexcept;

  /// Counts for the reader, too.
  DeviceReport& report() { return report_; }
  const DeviceReport& report() const { return report_; }

 private:
  static constexpr std::size_t kFrames = 16'384;  // two seconds of a full bus
  using Ring = board::InterruptRing<CanArrival, kFrames>;

  void run(const std::stop_token& stop) noexcept;
  void drain() noexcept;
  void keep(const CanReceived& received) noexcept;
  void lose_interface() noexcept;
  void find_interface() noexcept;
  std::string listen_again();

  const std::string interface_;
  const CanNeed need_;
  const std::vector<CanId> wanted_;
  const Warn warn_;
  DeviceReport report_;
  std::optional<CanSocket> socket_;  ///< none: the interface is gone
  std::optional<HardwareStamps> hardware_{std::in_place};
  LastingReason why_gone_;
  bool after_absence_ = false;
  const std::unique_ptr<Ring> ring_ = std::make_unique<Ring>();
  std::atomic<std::int64_t> complete_ns_;
  std::atomic<bool> gone_ = false;
  std::atomic<bool> told_ = false;  ///< the semaphore is released and not yet taken
  std::binary_semaphore came_{0};
  std::jthread thread_;
};

}  // namespace roadbalance
