#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "hil_tests/players/usb_board/bench_board.hpp"
#include "hil_tests/players/usb_board/usbip_port.hpp"

namespace roadbalance::test {

/// Faults that a test causes, once for each count.
struct UsbFaults {
  std::atomic<int> stall{0};      ///< the bulk endpoint halts until the host clears it
  std::atomic<int> cut{0};        ///< a packet ends before its time
  std::atomic<int> corrupt{0};    ///< a bit of a packet turns
  std::atomic<int> drop{0};       ///< a packet does not come
  std::atomic<int> deaf{0};       ///< a request of ours gets no answer
  std::atomic<bool> held{false};  ///< as long as it is set packets wait
};

/// A bench board as a USB device: its descriptors, EP0 and bulk endpoint.  The kernel's requests come in
/// through handle(), packets go out in serve(); both are called by one thread.
class UsbBoard {
 public:
  UsbBoard(Bench bench, unsigned port) : board_(std::move(bench)), port_(port) {}

  BenchBoard& board() { return board_; }
  UsbipPort& port() { return port_; }
  UsbFaults& faults() { return faults_; }

  /// A message of the kernel is there.
  void handle();
  /// Sends what is due.
  void serve();
  /// When the next packet is due that the host waits for; nothing: it waits for none.
  std::optional<MachineTime> due() const {
    return waiting_.empty() || faults_.held ? std::nullopt : std::optional(board_.due());
  }
  /// Plugged out: the board's power is gone.
  void power_off();

  std::int64_t packets_sent() const { return packets_sent_.load(std::memory_order_relaxed); }

 private:
  void answer_control(const Urb& urb);
  std::optional<std::size_t> standard_request(const board::SetupPacket& setup, std::span<std::uint8_t> reply);
  std::optional<std::size_t> descriptor(std::uint16_t which, std::span<std::uint8_t> reply) const;
  std::size_t spoil(std::span<std::uint8_t> packet, std::size_t size);

  BenchBoard board_;
  UsbipPort port_;
  UsbFaults faults_;
  std::vector<Urb> waiting_;  ///< requests to the bulk endpoint, in order
  bool halted_ = false;
  std::atomic<std::int64_t> packets_sent_{0};
};

}  // namespace roadbalance::test
