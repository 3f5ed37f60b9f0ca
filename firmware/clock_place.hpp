#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/clock/clock_socket.hpp"

namespace roadbalance {

/// Where a node's clock is asked for: a socket at this machine's address on the bus.  That may change while
/// the node measures: a lease ends, a network card is put in again.
class ClockPlace {
 public:
  /// @param address_now  this machine's IPv4 address on the bus; 0: it has none
  explicit ClockPlace(std::function<std::uint32_t()> address_now) : address_now_(std::move(address_now)) {}

  /// Opens a socket at the address that the machine has now, if that is another one; while it has none the
  /// socket stays.  Called by the thread that answers.
  /// @return why the clock cannot be asked at that address, once for each; empty: it can
  std::string follow();
  /// nullptr: nowhere yet.  Valid until follow() is called.
  ClockSocket* socket() const { return socket_.get(); }

  /// For any thread; address 0: nowhere.
  UdpAddress address() const;

 private:
  const std::function<std::uint32_t()> address_now_;
  std::unique_ptr<ClockSocket> socket_;
  std::atomic<std::uint64_t> reported_ = 0;  ///< address, then 16 bits of port
  std::optional<std::uint32_t> refused_;
};

}  // namespace roadbalance
