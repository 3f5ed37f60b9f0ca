#include "common/bus/message_run.hpp"

#include <netinet/udp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "common/bus/message_format.hpp"

namespace roadbalance {

MessageRun::MessageRun(const BusAddress& bus) : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  const auto ttl = static_cast<unsigned char>(bus.ttl);
  if (::setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl) != 0) refused_ = 0;
  group_.sin_family = AF_INET;
  group_.sin_port = htons(bus.port);
  group_.sin_addr.s_addr = htonl(bus.group);
  bytes_.reserve(kRoom);
}

MessageRun::~MessageRun() {
  if (socket_ >= 0) ::close(socket_);
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

std::span<const std::uint8_t> MessageRun::message(std::size_t k) const {
  return std::span(bytes_).subspan(k * datagram() + header_, length_);
}

bool MessageRun::send() {
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
  // Longer than the network's datagrams, or a kernel or network card that does not know how.
  if (errno == EMSGSIZE || errno == EINVAL || errno == EIO || errno == ENOPROTOOPT || errno == EOPNOTSUPP)
    refused_ = datagram();
  return false;
}

}  // namespace roadbalance
