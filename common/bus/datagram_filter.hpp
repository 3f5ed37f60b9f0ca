#pragma once

#include <cstdint>
#include <vector>

namespace roadbalance {

/// Keeps every datagram that is no LCM message of one packet away from the sockets on which LCM listens.
///
/// LCM 1.3.1 trusts what it receives: a fragment whose bounds wrap, or a fragment's header cut short, ends
/// the process (lcm#628), and a channel name without its end is read on into older packets.  Our messages are
/// single datagrams, so none of these is ever legitimate.  A filter in the kernel passes a datagram only if
/// it has the magic of a short message, its channel name ends within the datagram, and it is no longer than
/// kLargestDatagram.
///
/// LCM does not tell its socket: every UDP socket of this process that is bound to the bus's port is taken to
/// be one.  Between LCM's opening of the socket and attach(), some tenths of a millisecond, it is
/// unprotected.
class DatagramFilter {
 public:
  static constexpr std::uint32_t kLargestDatagram = 1500;
  static constexpr std::uint32_t kLongestChannel = 63;  ///< LCM's own limit

  DatagramFilter() = default;
  ~DatagramFilter();
  DatagramFilter(const DatagramFilter&) = delete;
  DatagramFilter& operator=(const DatagramFilter&) = delete;

  /// Attaches the filter to every such socket that has none yet.
  /// @throws std::system_error naming the port
  void attach(std::uint16_t port);

  /// Sockets that are protected.
  std::size_t sockets() const { return sockets_.size(); }
  /// Datagrams that the filter kept away or that found the receive buffer full, since the sockets were
  /// opened.
  std::int64_t dropped() const;

 private:
  std::vector<int> sockets_;  // duplicates of LCM's descriptors, so that they can be asked
};

}  // namespace roadbalance
