#include "hil_tests/guest/can_player.hpp"

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "hil_tests/program.hpp"
#include "hil_tests/throw_errno.hpp"

namespace roadbalance::test {
namespace {

void bring_up(const std::string& interface) {
  ip("link set " + interface + " mtu 72");
  ip("link set " + interface + " up");
}

}  // namespace

void ip(const std::string& words) {
  std::istringstream text(words);
  std::vector<std::string> arguments;
  for (std::string word; text >> word;) arguments.push_back(word);
  if (run("ip", arguments, 30) != 0) throw std::runtime_error("failed: ip " + words);
}

bool has_interface(const std::string& name) {
  return ::if_nametoindex(name.c_str()) != 0;
}

VirtualCan::VirtualCan(std::string name) : name_(std::move(name)) {
  ip("link add " + name_ + " type vcan");
  bring_up(name_);
}

VirtualCan::VirtualCan(std::string name, const std::string& other_end) : name_(std::move(name)) {
  ip("link add " + name_ + " type vxcan peer name " + other_end);
  bring_up(name_);
  bring_up(other_end);
}

VirtualCan::~VirtualCan() {
  if (has_interface(name_)) static_cast<void>(run("ip", {"link", "del", name_}, 30));
}

CanPlayer::CanPlayer(const std::string& interface)
    : descriptor_(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)) {
  if (descriptor_ < 0) throw_errno("open a CAN socket");
  const int on = 1;
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
  if (address.can_ifindex == 0 ||
      ::setsockopt(descriptor_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) != 0 ||
      ::setsockopt(descriptor_, SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0) != 0 ||
      ::bind(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const int error = errno;
    ::close(descriptor_);
    throw std::system_error(error, std::generic_category(), "play on " + interface);
  }
}

CanPlayer::~CanPlayer() {
  ::close(descriptor_);
}

void CanPlayer::send(const CanFrame& frame) {
  canfd_frame out{};
  out.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0);
  out.len = frame.size;
  if (frame.is_fd) out.flags = CANFD_BRS;
  std::copy_n(frame.data.begin(), frame.size, out.data);
  send_bytes(&out, frame.is_fd ? CANFD_MTU : CAN_MTU);
}

void CanPlayer::send_error(std::uint32_t error, std::uint8_t controller) {
  can_frame out{};
  out.can_id = CAN_ERR_FLAG | error;
  out.len = CAN_MAX_DLEN;
  out.data[1] = controller;
  send_bytes(&out, sizeof out);
}

void CanPlayer::send_bytes(const void* bytes, std::size_t size) {
  while (::write(descriptor_, bytes, size) != static_cast<ssize_t>(size)) {
    if (errno != ENOBUFS && errno != EAGAIN) throw_errno("send a CAN frame");
    ::usleep(100);  // poll() does not report when there is room again
  }
}

}  // namespace roadbalance::test
