#include "hil_tests/guest/serial_can.hpp"

#include <fcntl.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

#include "hil_tests/throw_errno.hpp"

namespace roadbalance::test {
namespace {

constexpr int kSerialCan = 17;  // N_SLCAN, the line discipline

void make_raw(int line) {
  termios settings{};
  ::tcgetattr(line, &settings);
  ::cfmakeraw(&settings);
  ::tcsetattr(line, TCSANOW, &settings);
}

}  // namespace

SerialCan::SerialCan() : adapter_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)), line_(-1) {
  if (adapter_ < 0 || ::grantpt(adapter_) != 0 || ::unlockpt(adapter_) != 0)
    throw_errno("open a pseudo-terminal");
  line_ = ::open(::ptsname(adapter_), O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (line_ < 0) throw_errno("open the pseudo-terminal's line");
  make_raw(line_);
  make_raw(adapter_);
  std::array<char, IFNAMSIZ> name{};
  if (::ioctl(line_, TIOCSETD, &kSerialCan) != 0) throw_errno("make a CAN interface of a serial line");
  if (::ioctl(line_, SIOCGIFNAME, name.data()) != 0) throw_errno("ask for the CAN interface's name");
  interface_ = name.data();
  // The kernel waits until its commands are read.
  listener_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      pollfd readable{adapter_, POLLIN, 0};
      std::array<char, 256> bytes;
      if (::poll(&readable, 1, 50) <= 0) continue;
      const ssize_t size = ::read(adapter_, bytes.data(), bytes.size());
      const std::lock_guard lock(mutex_);
      for (ssize_t k = 0; k < size; ++k)
        reported_ += bytes[static_cast<std::size_t>(k)] == '\r' ? '|' : bytes[static_cast<std::size_t>(k)];
    }
  });
}

SerialCan::~SerialCan() {
  ::close(line_);
  listener_ = {};
  ::close(adapter_);
}

void SerialCan::report(const std::string& words) const {
  const std::string line = words + "\r";
  if (::write(adapter_, line.data(), line.size()) != static_cast<ssize_t>(line.size()))
    throw_errno("report to slcan");
}

std::string SerialCan::told() const {
  const std::lock_guard lock(mutex_);
  return reported_;
}

}  // namespace roadbalance::test
