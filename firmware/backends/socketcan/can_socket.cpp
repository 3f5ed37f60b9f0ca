#include "firmware/backends/socketcan/can_socket.hpp"

#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <vector>

#include "common/types/clock_pair.hpp"

namespace roadbalance {
namespace {

using Kind = CanReceived::Kind;

// Two seconds of a full bus: each frame takes about 1 kB of the kernel's account.
constexpr int kBufferBytes = 16 << 20;
// How far wall and machine clock may drift apart by slewing (500 ppm at most) and reading errors.
constexpr double kSlew = 1e-3;
constexpr std::int64_t kReadingError_ns = 20'000;
constexpr auto kClocksAge = std::chrono::milliseconds(100);  // while the socket is never empty

can_filter filter_of(const CanId& wanted) {
  // Exactly this identifier; requests of data by others are none of ours.
  return wanted.extended ? can_filter{wanted.id | CAN_EFF_FLAG, CAN_EFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG}
                         : can_filter{wanted.id, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
}

/// The counters that an error frame stands for; nothing if it shows no more than the controller's state.
std::optional<DeviceCounter> trouble_of(const canfd_frame& frame) {
  if (frame.can_id & CAN_ERR_BUSOFF) return DeviceCounter::kBusOff;
  if (frame.can_id & CAN_ERR_CRTL) {
    if (frame.data[1] & CAN_ERR_CRTL_RX_OVERFLOW) return DeviceCounter::kControllerOverrun;
    if (frame.data[1] & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE))
      return DeviceCounter::kErrorPassive;
  }
  // A frame for error counters that passed the warning limit or fell below it, or for a restart, is no error
  // of its own: the errors themselves have frames, too.
  constexpr std::uint8_t kStates = CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING | CAN_ERR_CRTL_ACTIVE;
  const bool no_error =
      (frame.can_id & CAN_ERR_MASK & ~(CAN_ERR_CRTL | CAN_ERR_RESTARTED | CAN_ERR_CNT)) == 0;
  const bool only_state = (frame.can_id & CAN_ERR_CRTL) == 0 || (frame.data[1] & kStates) != 0;
  if (no_error && only_state) return std::nullopt;
  return DeviceCounter::kBusErrors;
}

std::int64_t ns_of(std::int64_t seconds, std::int64_t nanoseconds) {
  return seconds * 1'000'000'000LL + nanoseconds;
}

/// The kernel's control messages beside a frame.
struct Beside {
  std::optional<std::int64_t> wall_ns, hardware_ns;
  std::optional<std::uint32_t> lost_total;
};

Beside read_control(msghdr& head) {
  Beside beside;
  for (cmsghdr* part = CMSG_FIRSTHDR(&head); part; part = CMSG_NXTHDR(&head, part)) {
    if (part->cmsg_level != SOL_SOCKET) continue;
    if (part->cmsg_type == SCM_TIMESTAMPING) {
      scm_timestamping stamps;
      std::memcpy(&stamps, CMSG_DATA(part), sizeof stamps);
      if (stamps.ts[0].tv_sec != 0) beside.wall_ns = ns_of(stamps.ts[0].tv_sec, stamps.ts[0].tv_nsec);
      if (stamps.ts[2].tv_sec != 0 || stamps.ts[2].tv_nsec != 0)
        beside.hardware_ns = ns_of(stamps.ts[2].tv_sec, stamps.ts[2].tv_nsec);
    } else if (part->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t lost = 0;
      std::memcpy(&lost, CMSG_DATA(part), sizeof lost);
      beside.lost_total = lost;
    }
  }
  return beside;
}

}  // namespace

CanSocket::CanSocket(const std::string& interface, std::span<const CanId> wanted)
    : descriptor_(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)) {
  const auto demand = [&](bool done, const char* what) {
    if (done) return;
    const int error = errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    throw std::system_error(error, std::generic_category(), std::string(what) + " " + interface);
  };
  const auto set = [&](int level, int option, const auto& value) {
    return ::setsockopt(descriptor_, level, option, &value, sizeof value) == 0;
  };
  demand(descriptor_ >= 0, "open a CAN socket for");
  std::vector<can_filter> filters;
  for (const CanId& id : wanted) filters.push_back(filter_of(id));
  demand(::setsockopt(descriptor_, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                      static_cast<socklen_t>(filters.size() * sizeof(can_filter))) == 0,
         "choose frames of");
  demand(set(SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1), "receive CAN FD frames of");
  demand(set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_MASK}), "receive errors of");
  demand(set(SOL_SOCKET, SO_RXQ_OVFL, 1), "count lost frames of");
  const int stamps = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_RX_HARDWARE |
                     SOF_TIMESTAMPING_RAW_HARDWARE;
  demand(set(SOL_SOCKET, SO_TIMESTAMPING, stamps), "have frames stamped of");
  // The second is what an ordinary user gets; a buffer as large as the system lets is no error.
  if (!set(SOL_SOCKET, SO_RCVBUFFORCE, kBufferBytes))
    static_cast<void>(set(SOL_SOCKET, SO_RCVBUF, kBufferBytes));
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
  demand(address.can_ifindex != 0, "find CAN interface");
  demand(::bind(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0,
         "listen on CAN interface");
  // A system without sysfs has no such count; the socket's own is always there.
  dropped_descriptor_ =
      ::open(("/sys/class/net/" + interface + "/statistics/rx_dropped").c_str(), O_RDONLY | O_CLOEXEC);
  dropped_reported_ = dropped_before_the_socket();
  read_clocks();
  wall_clock_set_ = false;  // there is nothing yet to compare with
  clocks_fresh_ = false;
}

CanSocket::~CanSocket() {
  if (dropped_descriptor_ >= 0) ::close(dropped_descriptor_);
  ::close(descriptor_);
}

void CanSocket::wait(std::chrono::milliseconds at_most) const noexcept {
  pollfd socket{descriptor_, POLLIN, 0};
  static_cast<void>(::poll(&socket, 1, static_cast<int>(at_most.count())));
}

CanReceived CanSocket::receive() noexcept {
  CanReceived received;
  canfd_frame frame;
  iovec room{&frame, sizeof frame};
  alignas(cmsghdr) std::array<char, 512> control;
  msghdr message{};
  message.msg_iov = &room;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t size = ::recvmsg(descriptor_, &message, MSG_DONTWAIT);
  if (size < 0) {
    clocks_fresh_ = false;
    const bool empty = errno == EAGAIN || errno == EINTR || errno == ENOBUFS;
    received.kind = empty ? Kind::kNothing : Kind::kGone;
    return received;
  }
  const Beside beside = read_control(message);
  if (beside.lost_total) count_lost(*beside.lost_total);
  received.hardware_ns = beside.hardware_ns;
  received.time = machine_time(beside.wall_ns);
  if (size < static_cast<ssize_t>(CAN_MTU) || frame.len > CANFD_MAX_DLEN) {
    received.kind = Kind::kIgnored;
    return received;
  }
  if (frame.can_id & CAN_ERR_FLAG) {
    const auto trouble = trouble_of(frame);
    received.kind = trouble ? Kind::kTrouble : Kind::kIgnored;
    received.trouble = trouble.value_or(DeviceCounter::kBusErrors);
    return received;
  }
  received.kind = Kind::kFrame;
  received.frame.extended = (frame.can_id & CAN_EFF_FLAG) != 0;
  received.frame.id = frame.can_id & (received.frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  received.frame.is_fd = size == static_cast<ssize_t>(CANFD_MTU);
  received.frame.size = frame.len;
  std::copy_n(frame.data, frame.len, received.frame.data.begin());
  return received;
}

std::uint64_t CanSocket::take_lost() noexcept {
  // A frame carries what was lost before it; after the last one the socket itself has to be asked.
  std::array<std::uint32_t, SK_MEMINFO_VARS> memory{};
  socklen_t size = sizeof memory;
  if (::getsockopt(descriptor_, SOL_SOCKET, SO_MEMINFO, memory.data(), &size) == 0 &&
      size > SK_MEMINFO_DROPS * sizeof memory[0])
    count_lost(memory[SK_MEMINFO_DROPS]);
  const std::uint32_t in_socket = lost_total_ - lost_reported_;
  lost_reported_ = lost_total_;
  const std::uint64_t dropped = dropped_before_the_socket();
  const std::uint64_t before_socket = std::max(dropped, dropped_reported_) - dropped_reported_;
  dropped_reported_ += before_socket;
  return in_socket + before_socket;
}

std::uint64_t CanSocket::dropped_before_the_socket() const noexcept {
  std::array<char, 24> text{};
  std::uint64_t count = dropped_reported_;  // of an interface that has gone nothing more is known
  const ssize_t size = ::pread(dropped_descriptor_, text.data(), text.size(), 0);
  if (size > 0) static_cast<void>(std::from_chars(text.data(), text.data() + size, count));
  return count;
}

void CanSocket::count_lost(std::uint32_t total) noexcept {
  // A frame that waited carries an older count than the socket did.
  if (static_cast<std::int32_t>(total - lost_total_) > 0) lost_total_ = total;
}

void CanSocket::read_clocks() noexcept {
  const MachineTime now = MachineClock::now();
  const auto before = machine_minus_wall_;
  machine_minus_wall_ = machine_minus(CLOCK_REALTIME);
  const auto elapsed_ns = static_cast<double>((now - read_at_).count());
  const auto moved_ns = static_cast<double>(std::abs((machine_minus_wall_ - before).count()));
  wall_clock_set_ = moved_ns > static_cast<double>(kReadingError_ns) + kSlew * elapsed_ns;
  read_at_ = now;
  clocks_fresh_ = true;
}

MachineTime CanSocket::machine_time(std::optional<std::int64_t> wall_ns) noexcept {
  MachineTime time = MachineClock::now();
  if (!clocks_fresh_ || time - read_at_ > kClocksAge) read_clocks();
  if (wall_ns && !wall_clock_set_)
    time = std::min(time, machine_time_from_ns(*wall_ns + machine_minus_wall_.count()));
  newest_ = std::max(newest_, time);
  return newest_;
}

}  // namespace roadbalance
