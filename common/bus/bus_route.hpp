#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace roadbalance {

/// The socket holds so much for a recorder that is kept from reading.
inline constexpr int kReceiveBufferBytes = 4 << 20;

/// Where an LCM bus over UDP multicast is; numbers, not bytes as they are sent.
struct BusAddress {
  std::uint32_t group = 0xEFFF4C43;  ///< LCM's own default, 239.255.76.67
  std::uint16_t port = 7667;
  int ttl = 0;  ///< networks that a datagram may cross; 0: it stays on this machine
  int receive_buffer = kReceiveBufferBytes;  ///< that its sockets ask for; 0: what the kernel gives unasked
};

/// "udpm://GROUP:PORT?ttl=N&recv_buf_size=N", each part of which may be missing, as LCM reads it, but for
/// numbers that are not decimal and the receive buffer, for which LCM asks only if the URL gives it; nothing
/// if it is no such address.
std::optional<BusAddress> bus_address(const std::string& url);

/// This machine's own IPv4 address on the way to an LCM bus, as a number: others on the bus reach it there.
/// 0 if the bus is not UDP multicast or there is no route to it.
std::uint32_t address_on_bus(const std::string& url);

}  // namespace roadbalance
