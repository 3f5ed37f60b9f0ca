#include "hil_tests/players/usb_board/usbip_port.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>

namespace roadbalance::test {
namespace {

constexpr const char* kController = "/sys/devices/platform/vhci_hcd.0/";
constexpr unsigned kHighSpeed = 3;
constexpr unsigned kDeviceNumber = 0x10002;  // bus 1, device 2 of the machine that exports it; of no meaning
constexpr std::size_t kHeaderBytes = 48;
constexpr int kAttempts = 500;

enum Command : std::uint32_t { kSubmit = 1, kUnlink = 2, kSubmitted = 3, kUnlinkedAnswer = 4 };

/// Twelve big-endian numbers; the last two are the setup packet, in bytes.
using Header = std::array<std::uint8_t, kHeaderBytes>;

std::uint32_t number_at(const Header& header, std::size_t k) {
  return static_cast<std::uint32_t>(header[4 * k]) << 24 |
         static_cast<std::uint32_t>(header[4 * k + 1]) << 16 |
         static_cast<std::uint32_t>(header[4 * k + 2]) << 8 | header[4 * k + 3];
}

void put_number(Header& header, std::size_t k, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) header[4 * k + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
}

bool write_file(const std::string& path, const std::string& text) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0)
    throw std::runtime_error("no virtual USB host controller: " + path + ": " + std::strerror(errno));
  const bool written = ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  ::close(file);
  return written;
}

}  // namespace

UsbipPort::~UsbipPort() {
  unplug();
}

void UsbipPort::plug() {
  if (socket_ >= 0) return;
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0)
    throw std::runtime_error(std::string("socket pair: ") + std::strerror(errno));
  const std::string line = std::to_string(port_) + " " + std::to_string(pair[1]) + " " +
                           std::to_string(kDeviceNumber + port_) + " " + std::to_string(kHighSpeed);
  bool plugged = false;
  for (int k = 0; k < kAttempts && !plugged; ++k) {
    plugged = write_file(std::string(kController) + "attach", line);
    if (!plugged) std::this_thread::sleep_for(std::chrono::milliseconds(10));  // the kernel still unplugs
  }
  ::close(pair[1]);
  if (!plugged) {
    ::close(pair[0]);
    throw std::runtime_error("port " + std::to_string(port_) +
                             " of the virtual USB host controller is taken");
  }
  socket_ = pair[0];
}

void UsbipPort::unplug() {
  if (socket_ < 0) return;
  write_file(std::string(kController) + "detach", std::to_string(port_));
  close();
}

void UsbipPort::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

bool UsbipPort::read_all(std::span<std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), 0);
    if (size <= 0) {
      close();
      return false;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(size));
  }
  return true;
}

void UsbipPort::write_all(std::span<const std::uint8_t> bytes) {
  while (socket_ >= 0 && !bytes.empty()) {
    const ssize_t size = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (size <= 0) return close();
    bytes = bytes.subspan(static_cast<std::size_t>(size));
  }
}

std::optional<Urb> UsbipPort::receive(std::vector<Urb>& pending) {
  Header header;
  if (!read_all(header)) return std::nullopt;
  Urb urb;
  urb.number = number_at(header, 1);
  if (number_at(header, 0) == kUnlink) {
    const std::uint32_t wanted = number_at(header, 5);
    const auto found = std::ranges::find(pending, wanted, &Urb::number);
    Header answer{};
    put_number(answer, 0, kUnlinkedAnswer);
    put_number(answer, 1, urb.number);
    if (found != pending.end()) pending.erase(found);
    // One that has been completed the kernel does not look for any more; others were never answered.
    put_number(answer, 5, static_cast<std::uint32_t>(kUnlinked));
    write_all(answer);
    return std::nullopt;
  }
  urb.in = number_at(header, 3) == 1;
  urb.endpoint = number_at(header, 4);
  urb.length = number_at(header, 6);
  std::copy_n(header.end() - 8, 8, urb.setup.begin());
  if (!urb.in) {
    urb.data.resize(urb.length);
    if (!read_all(urb.data)) return std::nullopt;
  }
  return urb;
}

void UsbipPort::complete(const Urb& urb, std::int32_t status, std::span<const std::uint8_t> in_data) {
  const std::size_t sent = std::min<std::size_t>(in_data.size(), urb.length);
  const std::size_t actual = status != 0 ? 0 : urb.in ? sent : urb.data.size();
  Header header{};
  put_number(header, 0, kSubmitted);
  put_number(header, 1, urb.number);
  put_number(header, 5, static_cast<std::uint32_t>(status));
  put_number(header, 6, static_cast<std::uint32_t>(actual));
  write_all(header);
  if (urb.in && actual > 0) write_all(in_data.first(actual));
}

}  // namespace roadbalance::test
