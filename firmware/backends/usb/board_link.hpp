#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "firmware/backends/usb/board_setup.hpp"
#include "firmware/backends/usb/inbox.hpp"
#include "firmware/backends/usb/scan_flow.hpp"
#include "firmware/backends/usb/usb_address.hpp"
#include "firmware/backends/usb/usb_device.hpp"

namespace roadbalance {

/// Keeps the boards of a node open, set up and running, in a thread of its own, and puts what they send into
/// the inbox.  When one is gone, silent or gives no scans, all are closed, looked for five times a second,
/// and started together again; it counts as gone, once, until its scans come.
class BoardLink {
 public:
  /// Sets the boards up and starts them.
  /// @param reports  one for each board; they outlive this
  /// @param warn     see open_usb_front_end()
  /// @throws ConfigError if the vehicle asks for what a board does not have; UsbError
  BoardLink(UsbAddress address, VehicleConfig vehicle, const NodeConfig& node,
            std::vector<DeviceReport*> reports, std::function<void(const std::string&)> warn);

  Inbox& inbox() { return inbox_; }
  /// Which of the node's encoders are at the boards.
  const std::array<bool, kEncoderLines>& lines() const { return lines_; }

  /// The boards do not belong together any more in the run of this token: they are started anew, if it is
  /// still theirs.
  void start_again(std::uint32_t token) { slipped_.store(token, std::memory_order_relaxed); }

  /// The reader's: how a board's scans come in the run of this token.  Never blocks.
  void hear(std::size_t which, std::uint32_t token, const ScanFlow& flow) noexcept {
    if (flow.flows()) flowing_[which].store(token, std::memory_order_relaxed);
    dry_[which].store(flow.is_dry() ? token : kNoRun, std::memory_order_relaxed);
  }

 private:
  static constexpr std::int64_t kNoRun = -1;

  /// The boards as long as they are there.
  struct Session {
    UsbBus bus;
    std::uint32_t token = 0;
    const MachineClock::duration slept = MachineClock::slept();  ///< when it was begun
    std::vector<std::unique_ptr<UsbDevice>> board;
    std::vector<WallTime> heard;             ///< when each sent something last
    WallTime compared{};                     ///< when the first was asked for its time last
    std::chrono::milliseconds until_next{};  ///< and how long after that it is asked again
    ~Session();
  };

  std::unique_ptr<Session> begin_session(std::stop_token stop);
  board::Identity set_up(UsbDevice& device, std::size_t which, std::uint32_t& ticks_per_scan);
  void start(Session& session);
  void receive(Session& session, std::size_t which, std::span<const std::uint8_t> bytes);
  void run(std::stop_token stop, std::unique_ptr<Session> session);
  /// Until a board has to be started again.
  void serve(std::stop_token stop, Session& session);
  bool has_failed(const Session& session, std::size_t which);
  void welcome(const Session& session, std::size_t which);
  void compare_clocks(Session& session);
  std::unique_ptr<Session> find_again(std::stop_token stop);
  void warn_about(std::size_t which, const std::string& text) const;

  const UsbAddress address_;
  const VehicleConfig vehicle_;
  const NodeConfig node_;
  const std::vector<DeviceReport*> report_;
  const std::function<void(const std::string&)> warn_;
  Inbox inbox_;
  std::array<bool, kEncoderLines> lines_{};
  std::array<std::uint32_t, 2> dropped_{};  ///< not yet reported
  std::uint32_t runs_ = 0;
  std::atomic<std::int64_t> slipped_{-1};  ///< token of the last run that did
  std::array<std::atomic<std::int64_t>, 2> flowing_{kNoRun, kNoRun},
      dry_{kNoRun, kNoRun};  ///< the same, of a board's scans
  /// For a board of which no scan has come since.
  struct Away {
    bool is_counted = false;
    std::string reported;  ///< last
  };
  std::array<Away, 2> away_;
  std::vector<std::string> noted_;  ///< reported once
  std::jthread thread_;             ///< ends before the rest
};

}  // namespace roadbalance
