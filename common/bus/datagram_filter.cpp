#include "common/bus/datagram_filter.hpp"

#include <fcntl.h>
#include <linux/filter.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <string>
#include <system_error>

namespace roadbalance {
namespace {

constexpr std::uint32_t kUdpHeader = 8;    // a socket's filter sees the datagram from its UDP header on
constexpr std::uint32_t kShortHeader = 8;  // magic and number
constexpr std::uint32_t kMagicShort = 0x4c433032;

// Classic BPF has no loops: one pair of instructions for every byte a channel name may have.  A load behind
// the end of the datagram rejects it.
std::vector<sock_filter> one_packet_messages() {
  constexpr std::uint32_t kChannel = kUdpHeader + kShortHeader;
  constexpr std::uint32_t kBytes = DatagramFilter::kLongestChannel + 1;
  std::vector<sock_filter> program{
      BPF_STMT(BPF_LD | BPF_W | BPF_LEN, 0),
      BPF_JUMP(BPF_JMP | BPF_JGT | BPF_K, kUdpHeader + DatagramFilter::kLargestDatagram, 2, 0),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kUdpHeader),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kMagicShort, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, 0),
  };
  for (std::uint32_t k = 0; k < kBytes; ++k) {
    program.push_back(BPF_STMT(BPF_LD | BPF_B | BPF_ABS, kChannel + k));
    const auto to_accept = static_cast<std::uint8_t>(2 * (kBytes - 1 - k) + 1);
    program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, 0, to_accept, 0));
  }
  program.push_back(BPF_STMT(BPF_RET | BPF_K, 0));
  program.push_back(BPF_STMT(BPF_RET | BPF_K, 0xFFFFFFFF));
  return program;
}

bool is_bound_to(std::uint16_t port, int descriptor) {
  int type = 0;
  socklen_t size = sizeof type;
  if (::getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM) return false;
  sockaddr_in address{};
  size = sizeof address;
  return ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
         address.sin_family == AF_INET && ntohs(address.sin_port) == port;
}

std::vector<int> open_descriptors() {
  std::vector<int> all;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const std::string name = entry.path().filename();
    int descriptor = -1;
    std::from_chars(name.data(), name.data() + name.size(), descriptor);
    all.push_back(descriptor);
  }
  return all;
}

bool has_filter(int socket) {
  socklen_t instructions = 0;
  return ::getsockopt(socket, SOL_SOCKET, SO_GET_FILTER, nullptr, &instructions) == 0 && instructions > 0;
}

}  // namespace

DatagramFilter::~DatagramFilter() {
  for (const int socket : sockets_) ::close(socket);
}

void DatagramFilter::attach(std::uint16_t port) {
  auto program = one_packet_messages();
  const sock_fprog code{static_cast<unsigned short>(program.size()), program.data()};
  for (const int descriptor : open_descriptors()) {
    // Another thread may close it and open something else by this number: the duplicate stays what it is.
    const int socket = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
    if (socket < 0) continue;
    if (!is_bound_to(port, socket) || has_filter(socket)) {
      ::close(socket);
      continue;
    }
    sockets_.push_back(socket);
    if (::setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &code, sizeof code) != 0)
      throw std::system_error(errno, std::generic_category(),
                              "attach a filter to the bus's socket on port " + std::to_string(port));
  }
}

std::int64_t DatagramFilter::dropped() const {
  std::int64_t dropped = 0;
  for (const int socket : sockets_) {
    std::array<std::uint32_t, SK_MEMINFO_VARS> figures{};
    socklen_t size = sizeof figures;
    if (::getsockopt(socket, SOL_SOCKET, SO_MEMINFO, figures.data(), &size) == 0)
      dropped += figures[SK_MEMINFO_DROPS];
  }
  return dropped;
}

}  // namespace roadbalance
