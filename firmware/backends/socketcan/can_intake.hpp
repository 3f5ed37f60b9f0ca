#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "common/config/node_wiring.hpp"
#include "common/frontend/lasting_reason.hpp"
#include "common/process/waking_queue.hpp"
#include "common/types/scan.hpp"
#include "firmware/backends/socketcan/can_link.hpp"
#include "firmware/backends/socketcan/can_socket.hpp"
#include "firmware/backends/socketcan/hardware_stamps.hpp"

namespace roadbalance {

/// A CAN interface that cannot be used now; the text holds why, and the remedy.
class CanError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A frame that came, with its stamp on the machine's time line.
struct CanArrival {
  CanFrame frame;
  NodeTime time{};
  bool after_absence = false;  ///< the first since the interface was gone
};

/// A real-time thread that fetches the frames of an interface as they come and keeps them for one reader.
///
/// An interface that goes down or away is asked for by its name every 50 ms and used again once it is up in
/// its role; in another one it stays gone, and why is reported when that lasts.  Troubles are counted in the
/// report.  The reader's side never allocates; the thread only while the interface is gone, and to report
/// something.
class CanIntake {
 public:
  using Warn = std::function<void(const std::string&)>;
  using Sentence = std::function<std::string()>;

  /// @param wanted   identifiers; at least one
  /// @param warn     gets, from the thread, what the system refuses of its real-time priority, why an
  ///                 interface that went cannot be used again, and of silence
  /// @param silence  makes the sentence of report_silence(), in the thread; empty: that is never called
  /// @throws CanError if there is no such interface, or not up, or not as needed; std::system_error
  CanIntake(const std::string& interface, CanNeed need, std::vector<CanId> wanted, Warn warn,
            Sentence silence = {});
  CanIntake(const CanIntake&) = delete;
  CanIntake& operator=(const CanIntake&) = delete;
  ~CanIntake();

  /// The reader's: the oldest frame, or nullptr; it stays until pop().
  const CanArrival* front() const noexcept { return queue_.front(); }
  void pop() noexcept { queue_.pop(); }
  /// Until a frame is there.  False: none came.
  bool wait_until(WallTime at_most) noexcept { return queue_.wait_until(at_most); }

  /// Every frame stamped before is in the queue or was lost; of an interface that is gone: the present.
  NodeTime complete_until() const noexcept;

  /// The interface is away, for the reason given.
  bool gone() const noexcept { return gone_.load(std::memory_order_acquire); }

  /// The reader's: the frames it waits for do not come.  The thread reports that soon.
  void report_silence() noexcept { silent_.store(true, std::memory_order_relaxed); }

  /// Counts for the reader, too.
  DeviceReport& report() { return report_; }
  const DeviceReport& report() const { return report_; }

 private:
  static constexpr std::size_t kFrames = 16'384;  // two seconds of a full bus

  void run(const std::stop_token& stop) noexcept;
  void drain() noexcept;
  void count_lost() noexcept;
  void keep(const CanReceived& received) noexcept;
  void lose_interface() noexcept;
  void find_interface() noexcept;
  void warn_of_silence() noexcept;
  std::string listen_again();

  const std::string interface_;
  const CanNeed need_;
  const std::vector<CanId> wanted_;
  const Warn warn_;
  const Sentence silence_;
  DeviceReport report_;
  std::optional<CanSocket> socket_;  ///< none: the interface is gone
  std::optional<HardwareStamps> hardware_{std::in_place};
  LastingReason why_gone_;
  bool after_absence_ = false;
  WakingQueue<CanArrival> queue_{kFrames};
  std::atomic<std::int64_t> complete_ns_;
  std::atomic<bool> gone_ = false;
  std::atomic<bool> silent_ = false;  ///< to be reported
  std::jthread thread_;
};

}  // namespace roadbalance
