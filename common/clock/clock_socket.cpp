#include "common/clock/clock_socket.hpp"

#include <arpa/inet.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>

namespace roadbalance {
namespace {

// The kernel hands a stamp of sending back within microseconds, or not before the datagram has left a busy
// queue: then the own stamp has to do.
constexpr int kSendingStampWait_ms = 1;
// How far wall and machine clock may drift apart by slewing (500 ppm at most) and reading errors.
constexpr double kSlew = 1e-3;
constexpr std::int64_t kReadingError_ns = 20'000;
constexpr std::int64_t kTolerance_ns = 5'000;  // of a stamp beside the wait it belongs to

sockaddr_in to_sockaddr(const UdpAddress& udp) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(udp.port);
  out.sin_addr.s_addr = htonl(udp.address);
  return out;
}

UdpAddress local_address(int descriptor) {
  sockaddr_in own{};
  socklen_t size = sizeof own;
  if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&own), &size) != 0) return {};
  return {ntohl(own.sin_addr.s_addr), ntohs(own.sin_port)};
}

std::int64_t ns_of(const timespec& t) {
  return t.tv_sec * 1'000'000'000LL + t.tv_nsec;
}

std::int64_t wall_now_ns() {
  timespec t{};
  clock_gettime(CLOCK_REALTIME, &t);
  return ns_of(t);
}

/// The contents of one datagram's control messages.
struct Control {
  std::optional<std::int64_t> wall_ns;
  std::optional<std::uint32_t> number;  // of a datagram sent
};

Control read_control(msghdr& message) {
  Control control;
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level == SOL_SOCKET && part->cmsg_type == SCM_TIMESTAMPING) {
      scm_timestamping stamps;
      std::memcpy(&stamps, CMSG_DATA(part), sizeof stamps);
      if (stamps.ts[0].tv_sec != 0) control.wall_ns = ns_of({stamps.ts[0].tv_sec, stamps.ts[0].tv_nsec});
    } else if (part->cmsg_level == SOL_SOCKET && part->cmsg_type == SCM_TIMESTAMPNS) {
      timespec stamp;
      std::memcpy(&stamp, CMSG_DATA(part), sizeof stamp);
      control.wall_ns = ns_of(stamp);
    } else if (part->cmsg_level == IPPROTO_IP && part->cmsg_type == IP_RECVERR) {
      sock_extended_err error;
      std::memcpy(&error, CMSG_DATA(part), sizeof error);
      if (error.ee_origin == SO_EE_ORIGIN_TIMESTAMPING) control.number = error.ee_data;
    }
  }
  return control;
}

}  // namespace

UdpAddress address_towards(const UdpAddress& destination) {
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return {};
  const sockaddr_in to = to_sockaddr(destination);
  UdpAddress own;
  if (::connect(descriptor, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0)
    own = local_address(descriptor);
  ::close(descriptor);
  // That of the loopback is of no use to others, so that the kernel takes none for multicast, which could go
  // to them.
  if (own.port != 0 && own.address == INADDR_ANY) own.address = INADDR_LOOPBACK;
  return own;
}

ClockSocket::ClockSocket(std::uint32_t local)
    : descriptor_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)), emptied_(read_clocks()) {
  const sockaddr_in own = to_sockaddr({local, 0});
  if (descriptor_ < 0 || ::bind(descriptor_, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0) {
    const int error = errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    char text[INET_ADDRSTRLEN] = "";
    inet_ntop(AF_INET, &own.sin_addr, text, sizeof text);
    throw std::system_error(error, std::generic_category(),
                            std::string("open a UDP socket for clock exchanges at ") + text);
  }
  address_ = local_address(descriptor_);
  const int both = SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_TX_SOFTWARE |
                   SOF_TIMESTAMPING_OPT_ID | SOF_TIMESTAMPING_OPT_TSONLY;
  stamps_sending_ = ::setsockopt(descriptor_, SOL_SOCKET, SO_TIMESTAMPING, &both, sizeof both) == 0;
  if (!stamps_sending_) {
    const int on = 1;  // refused: then every stamp is this program's own, and is flagged so
    static_cast<void>(::setsockopt(descriptor_, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on));
  }
}

ClockSocket::~ClockSocket() {
  ::close(descriptor_);
}

ClockSocket::Clocks ClockSocket::read_clocks() {
  // The narrowest of three brackets counts: an interruption between two readings would shift the pair.
  Clocks best;
  std::int64_t narrowest = INT64_MAX;
  for (int i = 0; i < 3; ++i) {
    const MachineTime before = MachineClock::now();
    const std::int64_t wall_ns = wall_now_ns();
    const MachineTime after = MachineClock::now();
    const std::int64_t width = (after - before).count();
    if (width >= narrowest) continue;
    narrowest = width;
    best = {after, wall_ns - (to_ns(before) + width / 2)};
  }
  return best;
}

std::optional<MachineTime> ClockSocket::to_machine_time(std::int64_t wall_ns, const Clocks& before,
                                                        const Clocks& after) {
  const auto elapsed_ns = static_cast<double>((after.machine - before.machine).count());
  const std::int64_t moved_ns = after.wall_minus_machine_ns - before.wall_minus_machine_ns;
  if (std::abs(static_cast<double>(moved_ns)) > static_cast<double>(kReadingError_ns) + kSlew * elapsed_ns)
    return std::nullopt;  // the wall clock was set
  const std::int64_t ns = wall_ns - after.wall_minus_machine_ns;
  if (ns < to_ns(before.machine) - kTolerance_ns || ns > to_ns(after.machine) + kTolerance_ns)
    return std::nullopt;
  return machine_time_from_ns(ns);
}

std::optional<Stamp> ClockSocket::send(const UdpAddress& to, std::span<const std::uint8_t> bytes) {
  const sockaddr_in there = to_sockaddr(to);
  const Clocks before = read_clocks();
  const MachineTime now = MachineClock::now();
  if (::sendto(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL,
               reinterpret_cast<const sockaddr*>(&there), sizeof there) != static_cast<ssize_t>(bytes.size()))
    return std::nullopt;
  const std::uint32_t number = sent_++;
  if (!stamps_sending_) return Stamp{now, false};
  const auto wall_ns = sending_wall_ns(number);
  const auto time = wall_ns ? to_machine_time(*wall_ns, before, read_clocks()) : std::nullopt;
  return time ? Stamp{*time, true} : Stamp{now, false};
}

/// The kernel's stamp of the datagram just sent, from the socket's error queue.
std::optional<std::int64_t> ClockSocket::sending_wall_ns(std::uint32_t number) {
  for (;;) {
    std::array<char, 512> control;
    msghdr message{};
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    if (::recvmsg(descriptor_, &message, MSG_ERRQUEUE | MSG_DONTWAIT) >= 0) {
      const Control parts = read_control(message);
      if (parts.number == number) return parts.wall_ns;
      continue;  // of an earlier one that came late, or an ICMP error
    }
    pollfd queue{descriptor_, 0, 0};  // errors are always polled for
    if (errno != EAGAIN || ::poll(&queue, 1, kSendingStampWait_ms) <= 0) return std::nullopt;
  }
}

void ClockSocket::drop_late_stamps() {
  for (;;) {
    msghdr message{};
    if (::recvmsg(descriptor_, &message, MSG_ERRQUEUE | MSG_DONTWAIT) < 0) return;
  }
}

std::optional<ClockSocket::Datagram> ClockSocket::receive(std::chrono::milliseconds timeout) {
  Datagram datagram;
  sockaddr_in from{};
  iovec room{datagram.storage.data(), datagram.storage.size()};
  std::array<char, 512> control;
  const auto take = [&] {
    msghdr message{};
    message.msg_name = &from;
    message.msg_namelen = sizeof from;
    message.msg_iov = &room;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t size = ::recvmsg(descriptor_, &message, MSG_DONTWAIT);
    if (size < 0) return false;
    datagram.size = static_cast<std::size_t>(size);
    datagram.from = {ntohl(from.sin_addr.s_addr), ntohs(from.sin_port)};
    const Clocks after = read_clocks();
    const auto wall_ns = read_control(message).wall_ns;
    const auto time = wall_ns ? to_machine_time(*wall_ns, emptied_, after) : std::nullopt;
    datagram.received = time ? Stamp{*time, true} : Stamp{after.machine, false};
    return true;
  };
  if (take()) return datagram;
  emptied_ = read_clocks();
  pollfd socket{descriptor_, POLLIN, 0};
  if (::poll(&socket, 1, static_cast<int>(timeout.count())) <= 0) return std::nullopt;
  // Stamps that came too late for their datagrams: while they wait no poll does.
  if ((socket.revents & POLLERR) != 0) drop_late_stamps();
  if (take()) return datagram;
  return std::nullopt;
}

}  // namespace roadbalance
