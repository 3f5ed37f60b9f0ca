#include "common/bus/message_socket.hpp"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/if_packet.h>
#include <linux/sock_diag.h>
#include <netinet/udp.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>

namespace roadbalance {
namespace {

constexpr std::chrono::seconds kJoinAgain{1};
constexpr std::uint32_t kUdpHeader = 8;  // a socket's filter sees the datagram from its UDP header on

[[noreturn]] void throw_errno(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (const char byte : bytes) value = value << 8 | static_cast<std::uint8_t>(byte);
  return value;
}

sock_filter load(std::size_t bytes, std::uint32_t at) {
  const std::uint16_t size = bytes == 4 ? BPF_W : bytes == 2 ? BPF_H : BPF_B;
  return BPF_STMT(static_cast<std::uint16_t>(BPF_LD | BPF_ABS | size), at);
}

/// Passes the datagram if these bytes are at this place in it; goes on behind these instructions if not.
/// It checks the length first: a load behind the end would reject the datagram for all that follow, too.
void pass_if(std::string_view bytes, std::uint32_t at, std::vector<sock_filter>& program) {
  std::vector<sock_filter> test{
      BPF_STMT(BPF_LD | BPF_W | BPF_LEN, 0),
      BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, at + static_cast<std::uint32_t>(bytes.size()), 0, 0)};
  while (!bytes.empty()) {
    const std::size_t n = bytes.size() >= 4 ? 4 : bytes.size() >= 2 ? 2 : 1;
    test.push_back(load(n, at));
    test.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, big_endian(bytes.substr(0, n)), 0, 0));
    bytes.remove_prefix(n);
    at += static_cast<std::uint32_t>(n);
  }
  test.push_back(BPF_STMT(BPF_RET | BPF_K, 0xFFFFFFFF));
  for (std::size_t k = 1; k + 1 < test.size(); k += 2)
    test[k].jf = static_cast<std::uint8_t>(test.size() - 1 - k);
  program.insert(program.end(), test.begin(), test.end());
}

/// Passes what has come over a network.
void pass_from_afar(std::vector<sock_filter>& program) {
  program.push_back(
      BPF_STMT(BPF_LD | BPF_B | BPF_ABS, static_cast<std::uint32_t>(SKF_AD_OFF + SKF_AD_PKTTYPE)));
  program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, PACKET_MULTICAST, 0, 1));
  program.push_back(BPF_STMT(BPF_RET | BPF_K, 0xFFFFFFFF));
}

}  // namespace

Channels::Channels(const std::string& pattern)
    : text_(pattern.substr(0, pattern.find(".*"))), beginning_(text_.size() != pattern.size()) {
  if ((beginning_ && text_.size() + 2 != pattern.size()) ||
      text_.find_first_of(".*+?^$|()[]{}\\") != std::string::npos || text_.size() > kLongestChannel)
    throw std::invalid_argument("'" + pattern + "' is neither a channel's name nor a beginning of names");
}

MessageBatch::MessageBatch(Runs runs)
    // The room for long runs takes memory only where bytes have come.
    : places_(runs == Runs::kCut ? 32 : 16), controls_(places_.size()), headers_(places_.size()) {
  const std::size_t each = runs == Runs::kCut ? MessageSocket::kLargestDatagram : 1 << 16;
  room_ = std::make_unique_for_overwrite<std::uint8_t[]>(places_.size() * each);
  for (std::size_t k = 0; k < places_.size(); ++k) {
    places_[k] = {&room_[k * each], each};
    headers_[k].msg_hdr.msg_iov = &places_[k];
    headers_[k].msg_hdr.msg_iovlen = 1;
    headers_[k].msg_hdr.msg_control = controls_[k].of.data();
  }
  messages_.reserve(places_.size());
}

MessageSocket::MessageSocket(const BusAddress& bus, Runs runs)
    : group_(bus.group), socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)), runs_(runs) {
  if (socket_ < 0) throw_errno("open a socket");
  const int others_too = 1;
  sockaddr_in group{};
  group.sin_family = AF_INET;
  group.sin_port = htons(bus.port);
  group.sin_addr.s_addr = htonl(bus.group);
  const bool open =
      ::setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &others_too, sizeof others_too) == 0 &&
      (bus.receive_buffer == 0 ||
       ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bus.receive_buffer, sizeof bus.receive_buffer) == 0) &&
      ::bind(socket_, reinterpret_cast<const sockaddr*>(&group), sizeof group) == 0 && join();
  const int whole = 1;  // a kernel without this option cuts them
  if (open && runs == Runs::kWhole && ::setsockopt(socket_, IPPROTO_UDP, UDP_GRO, &whole, sizeof whole) != 0)
    runs_ = Runs::kCut;
  if (open) return;
  const int error = errno;
  ::close(socket_);
  errno = error;
  throw_errno("join the group");
}

MessageSocket::~MessageSocket() {
  ::close(socket_);
}

bool MessageSocket::join() {
  joined_ = std::chrono::steady_clock::now();
  ip_mreq member{};
  member.imr_multiaddr.s_addr = htonl(group_);  // over the interface of the route, as LCM does
  return ::setsockopt(socket_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &member, sizeof member) == 0;
}

void MessageSocket::stay_joined() {
  if (std::chrono::steady_clock::now() - joined_ < kJoinAgain || join()) return;
  // It is a member, or there is no interface at present.
  if (errno != ENOBUFS) return;
  const in_addr group{htonl(group_)};
  std::array<char, INET_ADDRSTRLEN> text{};
  throw_errno("join the group " + std::string(inet_ntop(AF_INET, &group, text.data(), text.size())) +
              " again, whose network card was replaced too often");
}

void MessageSocket::hear_only(std::span<const Channels> channels) {
  std::vector<sock_filter> program;
  if (runs_ == Runs::kWhole) pass_from_afar(program);
  for (const Channels& some : channels) pass_if(some.first_bytes(), kUdpHeader + kShortHeader, program);
  program.push_back(BPF_STMT(BPF_RET | BPF_K, 0));
  if (program.size() > BPF_MAXINSNS) return;
  const sock_fprog code{static_cast<unsigned short>(program.size()), program.data()};
  if (::setsockopt(socket_, SOL_SOCKET, SO_ATTACH_FILTER, &code, sizeof code) != 0 && errno != ENOMEM)
    throw_errno("attach a filter to the bus's socket");
}

bool MessageSocket::wait(std::chrono::milliseconds timeout) {
  stay_joined();
  pollfd one{socket_, POLLIN, 0};
  return ::poll(&one, 1, static_cast<int>(std::max<std::int64_t>(0, timeout.count()))) > 0;
}

bool MessageSocket::receive(MessageBatch& into) {
  const auto first = into.datagrams_;
  for (std::size_t k = first; k < into.headers_.size(); ++k)
    into.headers_[k].msg_hdr.msg_controllen = sizeof(MessageBatch::Control);
  const int came = ::recvmmsg(socket_, &into.headers_[first],
                              static_cast<unsigned>(into.headers_.size() - first), MSG_DONTWAIT, nullptr);
  if (came < 0 && errno != EAGAIN && errno != EINTR) throw_errno("receive");
  if (came <= 0) stay_joined();
  into.datagrams_ += static_cast<std::size_t>(std::max(0, came));
  for (std::size_t k = first; k < into.datagrams_; ++k) read(into, k);
  return into.datagrams_ > first;
}

/// One message, or of a run each.
void MessageSocket::read(MessageBatch& into, std::size_t datagram) {
  mmsghdr& header = into.headers_[datagram];
  std::span<const std::uint8_t> bytes(static_cast<const std::uint8_t*>(into.places_[datagram].iov_base),
                                      header.msg_len);
  if ((header.msg_hdr.msg_flags & MSG_TRUNC) != 0) {
    ++refused_;
    return;
  }
  std::size_t each = bytes.size();
  for (cmsghdr* about = CMSG_FIRSTHDR(&header.msg_hdr); about != nullptr;
       about = CMSG_NXTHDR(&header.msg_hdr, about)) {
    int length = 0;
    if (about->cmsg_level != IPPROTO_UDP || about->cmsg_type != UDP_GRO) continue;
    std::memcpy(&length, CMSG_DATA(about), sizeof length);
    if (length > 0) each = static_cast<std::size_t>(length);
  }
  do {
    const std::size_t length = std::min(each, bytes.size());
    read(into, bytes.first(length));
    bytes = bytes.subspan(length);
  } while (!bytes.empty());
}

void MessageSocket::read(MessageBatch& into, std::span<const std::uint8_t> message) {
  const auto* const text = reinterpret_cast<const char*>(message.data());
  const std::string_view rest(text, message.size());
  const auto end = rest.starts_with(kMagicShort)
                       ? rest.substr(0, kShortHeader + kLongestChannel + 1).find('\0', kShortHeader)
                       : std::string_view::npos;
  if (message.size() > kLargestDatagram || end == std::string_view::npos) {
    ++refused_;
    return;
  }
  into.messages_.push_back({rest.substr(kShortHeader, end - kShortHeader), message.subspan(end + 1)});
}

std::int64_t MessageSocket::receive_buffer() const {
  int twice = 0;  // the kernel counts its own needs with as much again: socket(7)
  socklen_t size = sizeof twice;
  if (::getsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &twice, &size) != 0)
    throw_errno("ask for the receive buffer of the bus's socket");
  return twice / 2;
}

std::int64_t MessageSocket::dropped() const {
  std::array<std::uint32_t, SK_MEMINFO_VARS> figures{};
  socklen_t size = sizeof figures;
  if (::getsockopt(socket_, SOL_SOCKET, SO_MEMINFO, figures.data(), &size) != 0) return refused_;
  return refused_ + figures[SK_MEMINFO_DROPS];
}

}  // namespace roadbalance
