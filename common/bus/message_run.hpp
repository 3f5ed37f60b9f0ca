#pragma once

#include <netinet/in.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/bus/bus_route.hpp"

namespace roadbalance {

/// Messages of one length on one channel, one after the other, that go by one system call: the kernel makes
/// datagrams of them, each as LCM would have sent it (UDP_SEGMENT).
///
/// The kernel takes nearly all the time of a datagram, and takes it anew for each socket of the group: 4.7 us
/// for 1376 bytes with two sockets that hear it and four that do not, 0.2 us in a run that its hearers take
/// whole (MessageSocket).
class MessageRun {
 public:
  /// @throws std::system_error if there is no socket for it
  explicit MessageRun(const BusAddress& bus);
  ~MessageRun();
  MessageRun(const MessageRun&) = delete;
  MessageRun& operator=(const MessageRun&) = delete;

  /// Takes it behind those that wait.  False if it does not fit there: another channel or length, or no room.
  bool add(const std::string& channel, std::span<const std::uint8_t> bytes);

  /// Sends all that wait: by one call, or one by one where the computer does not send them so, e.g. over a
  /// network whose datagrams are smaller; it is not asked again for messages as long.  Returns how many could
  /// not be sent; none waits any more.
  std::size_t send();

 private:
  static constexpr std::size_t kMost = 64;      // that the kernel takes
  static constexpr std::size_t kRoom = 65'507;  // of a datagram over IPv4

  std::size_t datagram() const { return header_ + length_; }
  bool send_together();
  bool send_one(std::size_t k);

  int socket_;
  sockaddr_in group_{};
  std::uint32_t number_ = 0;        ///< of the next message, as LCM counts them
  std::size_t refused_ = SIZE_MAX;  ///< datagrams from this length on are not asked for again
  std::string channel_;
  std::size_t header_ = 0, length_ = 0;  ///< of each datagram before the message, and of the message
  std::size_t messages_ = 0;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace roadbalance
