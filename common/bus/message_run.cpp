#include "common/bus/message_run.hpp"

#include <netinet/udp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "common/bus/message_format.hpp"

namespace roadbalance {

MessageRun::MessageRun(const BusAddress& bus) : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const auto ttl = static_cast<unsigned char>(bus.ttl);
  if (socket_ < 0 || ::setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) != 0) {
    const int error = errno;
    if (socket_ >= 0) ::close(socket_);
    throw std::system_error(error, std::generic_category(), "open a socket for runs of messages");
  }
  group_.sin_family = AF_INET;
  group_.sin_port = htons(bus.port);
  group_.sin_addr.s_addr = htonl(bus.group);
  bytes_.reserve(kRoom);
}

MessageRun::~MessageRun() {
  ::close(socket_);
}

bool MessageRun::add(const std::string& channel, std::span<const std::uint8_t> bytes) {
  if (messages_ == 0) {
    if (channel.size() > kLongestChannel || kShortHeader + channel.size() + 1 + bytes.size() > kRoom)
      return false;
    channel_ = channel;
    header_ = kShortHeader + channel.size() + 1;
    length_ = bytes.size();
    bytes_.clear();
  } else if (messages_ == kMost || bytes.size() != length_ || channel != channel_ ||
             bytes_.size() + datagram() > kRoom) {
    return false;
  }
  const std::size_t at = bytes_.size();
  bytes_.resize(at + datagram());
  std::uint8_t* const to = &bytes_[at];
  std::memcpy(to, kMagicShort.data(), kMagicShort.size());
  const std::uint32_t number = htonl(number_++);
  std::memcpy(to + kMagicShort.size(), &number, sizeof number);
  std::memcpy(to + kShortHeader, channel.c_str(), channel.size() + 1);
  if (!bytes.empty()) std::memcpy(to + header_, bytes.data(), bytes.size());
  ++messages_;
  return true;
}

std::size_t MessageRun::send() {
  const std::size_t waiting = std::exchange(messages_, 0);
  if (waiting > 1 && send_together()) return 0;
  std::size_t unsent = 0;
  for (std::size_t k = 0; k < waiting; ++k) unsent += send_one(k) ? 0 : 1;
  return unsent;
}

bool MessageRun::send_together() {
  if (datagram() >= refused_) return false;
  iovec all{bytes_.data(), bytes_.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(std::uint16_t))> control{};
  msghdr message{};
  message.msg_name = &group_;
  message.msg_namelen = sizeof group_;
  message.msg_iov = &all;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const about = CMSG_FIRSTHDR(&message);
  about->cmsg_level = IPPROTO_UDP;
  about->cmsg_type = UDP_SEGMENT;
  about->cmsg_len = CMSG_LEN(sizeof(std::uint16_t));
  const auto each = static_cast<std::uint16_t>(datagram());
  std::memcpy(CMSG_DATA(about), &each, sizeof each);
  if (::sendmsg(socket_, &message, 0) == static_cast<ssize_t>(bytes_.size())) return true;
  // Longer than the network's datagrams, or a kernel or network card that cannot.
  if (errno == EMSGSIZE || errno == EINVAL || errno == EIO || errno == ENOPROTOOPT || errno == EOPNOTSUPP)
    refused_ = datagram();
  return false;
}

/// By the same socket, so that the network keeps their order.
bool MessageRun::send_one(std::size_t k) {
  return ::sendto(socket_, &bytes_[k * datagram()], datagram(), 0, reinterpret_cast<const sockaddr*>(&group_),
                  sizeof group_) == static_cast<ssize_t>(datagram());
}

}  // namespace roadbalance
