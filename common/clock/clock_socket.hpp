#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/clock/datagram.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// One end of a UDP path, IPv4.
struct UdpAddress {
  std::uint32_t address = 0;  ///< as a number: 127.0.0.1 is 0x7F000001; 0: none
  std::uint16_t port = 0;
  bool operator==(const UdpAddress&) const = default;
};

/// This machine's own address on the way to `destination`; address 0 if there is no way.  A machine without a
/// network, whose way leads to itself, has 127.0.0.1.  Nothing is sent.
UdpAddress address_towards(const UdpAddress& destination);

/// An instant at which a datagram passed.
struct Stamp {
  MachineTime time{};
  bool by_kernel = false;  ///< else taken by this program, later than the kernel's would be
};

/// A UDP socket that reports when its datagrams passed the kernel, by MachineClock.
///
/// The kernel stamps in wall time.  The wall clock is compared with that around each wait; a
/// stamp over a step of the wall clock, or one that lies outside the wait, is replaced by this program's own.
class ClockSocket {
 public:
  /// Bound to `local` (0: any address) and a port of the kernel's choice.
  /// @throws std::system_error naming the address
  explicit ClockSocket(std::uint32_t local);
  ~ClockSocket();
  ClockSocket(const ClockSocket&) = delete;
  ClockSocket& operator=(const ClockSocket&) = delete;

  const UdpAddress& address() const { return address_; }

  /// Nothing if the system would not send it.
  std::optional<Stamp> send(const UdpAddress& to, std::span<const std::uint8_t> bytes);

  struct Datagram {
    UdpAddress from;
    std::array<std::uint8_t, kClockDatagramBytes + 1> storage{};  ///< one more, so that a longer one shows
    std::size_t size = 0;
    Stamp received;

    std::span<const std::uint8_t> bytes() const { return {storage.data(), size}; }
  };
  /// Waits for one datagram, at most `timeout`.
  std::optional<Datagram> receive(std::chrono::milliseconds timeout);

 private:
  /// One reading of both clocks.
  struct Clocks {
    MachineTime machine{};
    std::int64_t wall_minus_machine_ns = 0;
  };
  static Clocks read_clocks();
  static std::optional<MachineTime> to_machine_time(std::int64_t wall_ns, const Clocks& before,
                                                    const Clocks& after);
  std::optional<std::int64_t> sending_wall_ns(std::uint32_t number);
  void drop_late_stamps();

  int descriptor_;
  UdpAddress address_;
  bool stamps_sending_ = false;
  std::uint32_t sent_ = 0;  ///< datagrams, as the kernel numbers them
  Clocks emptied_;          ///< when the socket was last known to hold nothing
};

}  // namespace roadbalance
