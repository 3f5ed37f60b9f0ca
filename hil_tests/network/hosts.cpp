#include "hil_tests/network/hosts.hpp"

#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "hil_tests/program.hpp"
#include "hil_tests/throw_errno.hpp"

namespace roadbalance::test {
namespace {

constexpr const char* kInterface = "rb0";
constexpr std::chrono::milliseconds kLongestWait{20};

void ip(const std::vector<std::string>& words) {
  if (run("ip", words, 30) == 0) return;
  std::string line = "ip";
  for (const auto& word : words) line += " " + word;
  throw std::runtime_error("failed: " + line);
}

int open_network() {
  const int network = ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
  if (network < 0) throw_errno("open /proc/thread-self/ns/net");
  return network;
}

/// Frames written to it arrive at the interface, frames the interface sends are read from it.
int open_tap() {
  const int tap = ::open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (tap < 0) throw_errno("open /dev/net/tun");
  ifreq request{};
  std::strncpy(request.ifr_name, kInterface, IFNAMSIZ - 1);
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  if (::ioctl(tap, TUNSETIFF, &request) != 0) throw_errno("make TAP interface");
  return tap;
}

}  // namespace

std::optional<std::string> Hosts::refusal() {
  if (::geteuid() != 0) return "networks of one's own need root; try: unshare -Urnm ctest ...";
  if (::access("/dev/net/tun", R_OK | W_OK) != 0) return "there is no /dev/net/tun";
  // A container may be root and yet have no right to these: tried in a thread, which leaves its network with
  // it.
  std::optional<std::string> why;
  std::thread([&why] {
    try {
      if (::unshare(CLONE_NEWNET) != 0) throw_errno("make a network of its own");
      ::close(open_tap());
    } catch (const std::system_error& error) {
      why = error.what();
    }
  }).join();
  return why;
}

Hosts::Hosts(std::size_t count) : home_(open_network()), cable_(count, 1) {
  for (std::size_t host = 0; host < count; ++host) make_host(host);
  carrier_ = std::jthread([this](const std::stop_token& stop) { carry(stop); });
  enter(network_[0]);
}

Hosts::~Hosts() {
  carrier_ = {};
  ::setns(home_, CLONE_NEWNET);
  for (const int descriptor : network_) ::close(descriptor);
  for (const int descriptor : tap_) ::close(descriptor);
  ::close(home_);
}

void Hosts::make_host(std::size_t number) {
  if (::unshare(CLONE_NEWNET) != 0) throw_errno("make a network of its own");
  network_.push_back(open_network());
  tap_.push_back(open_tap());
  ip({"link", "set", "lo", "up"});
  set_up_interface(number);
}

void Hosts::set_up_interface(std::size_t number) {
  ip({"address", "add", "10.77.0." + std::to_string(number + 1) + "/24", "dev", kInterface});
  ip({"link", "set", kInterface, "up"});
  ip({"route", "add", "224.0.0.0/4", "dev", kInterface});
}

void Hosts::replace_interface(std::size_t host) {
  carrier_ = {};
  on(host, [&] {
    ::close(tap_.at(host));  // takes the interface with it
    tap_.at(host) = open_tap();
    set_up_interface(host);
  });
  carrier_ = std::jthread([this](const std::stop_token& stop) { carry(stop); });
}

void Hosts::enter(int network) const {
  if (::setns(network, CLONE_NEWNET) != 0) throw_errno("enter a network");
}

Hosts::Visit::Visit(const Hosts& hosts, std::size_t host) : hosts_(hosts) {
  hosts.enter(hosts.network_.at(host));
}

Hosts::Visit::~Visit() {
  ::setns(hosts_.network_[0], CLONE_NEWNET);
}

std::string Hosts::impair(std::size_t host, const CableFaults& faults) {
  const auto mean = (faults.shortest + faults.longest) / 2, spread = (faults.longest - faults.shortest) / 2;
  const auto percent = [](double probability) { return std::to_string(100 * probability) + "%"; };
  const auto us = [](std::chrono::microseconds time) { return std::to_string(time.count()) + "us"; };
  if (netem(host, {"loss", percent(faults.loss), "duplicate", percent(faults.duplicates), "delay", us(mean),
                   us(spread)}))
    return "netem";
  const std::lock_guard lock(mutex_);
  cable_.set_faults(host, faults);
  return "the relay";
}

bool Hosts::netem(std::size_t host, std::vector<std::string> words) const {
  const std::vector<std::string> begin{"-force", "qdisc", "replace", "dev", kInterface, "root", "netem"};
  words.insert(words.begin(), begin.begin(), begin.end());
  return on(host, [&] { return run("tc", words, 30) == 0; });
}

void Hosts::pull(std::size_t host) {
  const std::lock_guard lock(mutex_);
  cable_.pull(host);
}

void Hosts::plug(std::size_t host) {
  const std::lock_guard lock(mutex_);
  cable_.plug(host);
}

Cable::Counts Hosts::counts() {
  const std::lock_guard lock(mutex_);
  return cable_.counts();
}

void Hosts::carry(const std::stop_token& stop) {
  std::vector<pollfd> ready;
  for (const int tap : tap_) ready.push_back({.fd = tap, .events = POLLIN, .revents = 0});
  std::chrono::nanoseconds wait = kLongestWait;
  while (!stop.stop_requested()) {
    const timespec timeout{0, static_cast<long>(wait.count())};
    ::ppoll(ready.data(), ready.size(), &timeout, nullptr);
    const std::lock_guard lock(mutex_);
    for (std::size_t host = 0; host < ready.size(); ++host)
      if (ready[host].revents != 0) take_all(host);
    const WallTime now = WallClock::now();
    deliver(now);
    const auto next = cable_.next_arrival();
    wait = next ? std::clamp<std::chrono::nanoseconds>(*next - now, std::chrono::nanoseconds(0), kLongestWait)
                : kLongestWait;
  }
}

void Hosts::take_all(std::size_t host) {
  std::array<std::uint8_t, 2048> frame;
  for (ssize_t size = 0; (size = ::read(tap_[host], frame.data(), frame.size())) > 0;)
    cable_.take(host, std::span(frame).first(static_cast<std::size_t>(size)), WallClock::now());
}

void Hosts::deliver(WallTime now) {
  while (const auto frame = cable_.arrived(now))
    if (::write(tap_[frame->to], frame->bytes.data(), frame->bytes.size()) < 0 && errno != EAGAIN) return;
}

}  // namespace roadbalance::test
