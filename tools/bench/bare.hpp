#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "common/bus/process_port.hpp"

// Network and disk with nothing of ours between: the floors of the link, the recorder and the chain.

namespace roadbalance::bench {

constexpr int kMostBurst = 32;

/// Multicast on loopback and back, a burst of at most kMostBurst at a time, as many by one call as there are.
class BareUdp {
 public:
  explicit BareUdp(std::size_t bytes) : datagram_(bytes), room_(kMostBurst, datagram_) {
    for (std::size_t k = 0; k < kMostBurst; ++k) {
      places_[k] = {room_[k].data(), bytes};
      headers_[k].msg_hdr.msg_iov = &places_[k];
      headers_[k].msg_hdr.msg_iovlen = 1;
    }
    const int reuse = 1, room = 4 << 20;
    ::setsockopt(in_, SOL_SOCKET, SO_REUSEADDR, &reuse, sizeof reuse);
    ::setsockopt(in_, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    group_.sin_family = AF_INET;
    group_.sin_port = htons(static_cast<std::uint16_t>(process_port(1)));
    group_.sin_addr.s_addr = inet_addr("239.255.76.67");
    ip_mreq join{};
    join.imr_multiaddr = group_.sin_addr;
    const unsigned char ttl = 0;
    ::setsockopt(out_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
    if (::bind(in_, reinterpret_cast<const sockaddr*>(&group_), sizeof group_) != 0 ||
        ::setsockopt(in_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &join, sizeof join) != 0)
      throw std::runtime_error("no socket for the bare datagrams");
  }
  ~BareUdp() {
    ::close(in_);
    ::close(out_);
  }
  BareUdp(const BareUdp&) = delete;
  BareUdp& operator=(const BareUdp&) = delete;

  void burst(int blocks) {
    const auto size = static_cast<ssize_t>(datagram_.size());
    for (int k = 0; k < blocks; ++k)
      if (::sendto(out_, datagram_.data(), datagram_.size(), 0, reinterpret_cast<const sockaddr*>(&group_),
                   sizeof group_) != size)
        throw std::runtime_error("a bare datagram was not sent");
    for (int k = 0; k < blocks;) {
      const int came =
          ::recvmmsg(in_, headers_.data(), static_cast<unsigned>(blocks - k), MSG_WAITFORONE, nullptr);
      if (came <= 0) throw std::runtime_error("a bare datagram did not come");
      k += came;
    }
  }

 private:
  std::vector<std::uint8_t> datagram_;
  std::vector<std::vector<std::uint8_t>> room_;
  std::array<iovec, kMostBurst> places_{};
  std::array<mmsghdr, kMostBurst> headers_{};
  sockaddr_in group_{};
  int in_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0),
      out_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

inline void check_file(bool good, const std::filesystem::path& file) {
  if (!good) throw std::system_error(errno, std::generic_category(), file.string());
}

/// Writes so many bytes, each turn of them on the disk before the next: `dd bs=TURN oflag=dsync`.
inline void write_bare(std::uintmax_t bytes, std::size_t turn, const std::filesystem::path& file) {
  const std::vector<char> commit(turn, 'x');
  const int out = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_DSYNC | O_CLOEXEC, 0600);
  check_file(out >= 0, file);
  while (bytes > 0) {
    const std::size_t some = std::min<std::uintmax_t>(bytes, commit.size());
    check_file(::write(out, commit.data(), some) == static_cast<ssize_t>(some), file);
    bytes -= some;
  }
  check_file(::close(out) == 0, file);
}

}  // namespace roadbalance::bench
