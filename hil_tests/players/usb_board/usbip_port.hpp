#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace roadbalance::test {

/// A request of the kernel's USB stack to the device at a port.
struct Urb {
  std::uint32_t number = 0;
  std::uint32_t endpoint = 0;
  bool in = false;
  std::uint32_t length = 0;  ///< of the buffer
  std::array<std::uint8_t, 8> setup{};
  std::vector<std::uint8_t> data;  ///< of an OUT request
};

/// A port of the kernel's virtual USB host controller (vhci_hcd), to which this process plugs a device of its
/// own making: the kernel enumerates it as if it hung on a wire.
///
/// Protocol: Linux, Documentation/usb/usbip_protocol.rst.  A socket pair takes the place of the network.
class UsbipPort {
 public:
  static constexpr std::int32_t kStalled = -32;    ///< -EPIPE
  static constexpr std::int32_t kUnlinked = -104;  ///< -ECONNRESET

  /// @param port  0 .. 7, high speed
  explicit UsbipPort(unsigned port) : port_(port) {}
  UsbipPort(const UsbipPort&) = delete;
  UsbipPort& operator=(const UsbipPort&) = delete;
  ~UsbipPort();

  /// Waits until the kernel has cleared the port.
  /// @throws std::runtime_error if there is no vhci_hcd or the port stays taken
  void plug();
  void unplug();

  /// To be polled; -1: unplugged.
  int socket() const { return socket_; }

  /// Reads one message.  An unlinked request is taken out of `pending`, and answered.
  /// @return the new request; nothing if it was an unlinking, or if the kernel hung up
  std::optional<Urb> receive(std::vector<Urb>& pending);

  /// @param status  0 or kStalled
  void complete(const Urb& urb, std::int32_t status, std::span<const std::uint8_t> in_data);

 private:
  bool read_all(std::span<std::uint8_t> bytes);
  void write_all(std::span<const std::uint8_t> bytes);
  void close();

  const unsigned port_;
  int socket_ = -1;
};

}  // namespace roadbalance::test
