#include "hil_tests/guest/pulse_chip.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "common/types/clocks.hpp"
#include "hil_tests/throw_errno.hpp"

namespace roadbalance::test {
namespace {

constexpr const char* kPlayer = "/dev/gpio-pulse";
const std::string kDevices = "/sys/bus/platform/devices/";
constexpr const char* kChip = "gpio-pulse";
constexpr const char* kTwin = "gpio-pulse.1";
constexpr const char* kDriver = "/sys/bus/platform/drivers/gpio-pulse/";

void tell_driver(const std::string& file, const char* device) {
  if (!(std::ofstream(kDriver + file) << device << std::flush)) throw_errno(kDriver + file + " of " + device);
}

std::string chip_of(const std::string& device) {
  for (const auto& entry : std::filesystem::directory_iterator(kDevices + device))
    if (const std::string name = entry.path().filename(); name.starts_with("gpiochip")) return name;
  throw std::runtime_error("the chip " + device + " is unplugged");
}

}  // namespace

PulseChip::PulseChip() : player_(::open(kPlayer, O_RDWR | O_CLOEXEC)) {
  if (player_ < 0) throw_errno(std::string("open ") + kPlayer);
}

PulseChip::~PulseChip() {
  ::close(player_);
}

std::int64_t PulseChip::now_ns() {
  return to_ns(WallClock::now());
}

std::string PulseChip::name() {
  return chip_of(kChip);
}

void PulseChip::play(std::span<const gpio_pulse_step> steps) {
  auto bytes = std::as_bytes(steps);
  while (!bytes.empty()) {
    const ssize_t taken = ::write(player_, bytes.data(), bytes.size());
    if (taken < 0) throw_errno(std::string("write to ") + kPlayer);
    bytes = bytes.subspan(static_cast<std::size_t>(taken));
  }
}

void PulseChip::set(unsigned line, bool high) {
  if (::fsync(player_) != 0) throw_errno(std::string("wait for ") + kPlayer);
  const gpio_pulse_step step{static_cast<std::uint64_t>(now_ns()), line, high};
  play({&step, 1});
  if (::fsync(player_) != 0) throw_errno(std::string("wait for ") + kPlayer);
}

std::vector<gpio_pulse_step> PulseChip::played() {
  std::vector<gpio_pulse_step> all;
  std::array<gpio_pulse_step, 4096> part;
  while (true) {
    const ssize_t size = ::read(player_, part.data(), sizeof part);
    if (size < 0) throw_errno(std::string("read ") + kPlayer);
    if (size == 0) return all;
    all.insert(all.end(), part.begin(), part.begin() + size / static_cast<ssize_t>(sizeof part[0]));
  }
}

void PulseChip::unplug() {
  tell_driver("unbind", kChip);
}

void PulseChip::plug() {
  tell_driver("bind", kChip);
}

void PulseChip::plug_twin() {
  tell_driver("bind", kTwin);
}

void PulseChip::unplug_twin() {
  tell_driver("unbind", kTwin);
}

std::string PulseChip::twin_name() {
  return chip_of(kTwin);
}

}  // namespace roadbalance::test
