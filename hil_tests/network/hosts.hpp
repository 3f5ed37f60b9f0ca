#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hil_tests/network/cable.hpp"

namespace roadbalance::test {

/// Computers of their own on one bad cable: network namespaces of this kernel, each with a TAP interface
/// 10.77.0.<k + 1>/24 and a multicast route, and a thread that carries frames between the interfaces.
///
/// The thread that made this object is on host 0 until the object goes: sockets it opens and programs it
/// starts are there.  Everything ends with the process; nothing else on the computer notices.
class Hosts {
 public:
  /// Why there can be none here, or nothing.
  static std::optional<std::string> refusal();

  /// @throws std::system_error, std::runtime_error naming what failed
  explicit Hosts(std::size_t count);
  ~Hosts();
  Hosts(const Hosts&) = delete;
  Hosts& operator=(const Hosts&) = delete;

  /// Calls `action` as on this host.
  template <typename Action>
  auto on(std::size_t host, Action&& action) const {
    const Visit visit(*this, host);
    return action();
  }

  /// Frames that leave a host; by the kernel's netem if it has that, else by the cable.  Returns which.
  std::string impair(std::size_t host, const CableFaults& faults);
  /// The same by the kernel's netem, in the words of `tc`, e.g. {"corrupt", "5%"}; false if it has none.
  bool netem(std::size_t host, std::vector<std::string> words) const;
  void pull(std::size_t host);
  void plug(std::size_t host);
  /// Takes a host's interface out and puts another one in, with the same name, address and route: as a
  /// network card at a USB port that is pulled.
  void replace_interface(std::size_t host);
  Cable::Counts counts();

 private:
  class Visit {
   public:
    Visit(const Hosts& hosts, std::size_t host);
    ~Visit();

   private:
    const Hosts& hosts_;
  };
  void enter(int network) const;
  void make_host(std::size_t number);
  static void set_up_interface(std::size_t number);
  void carry(const std::stop_token& stop);
  void take_all(std::size_t host);
  void deliver(WallTime now);

  int home_ = -1;             // network the thread came from
  std::vector<int> network_;  // [host]
  std::vector<int> tap_;      // [host]
  std::mutex mutex_;          // guards cable_
  Cable cable_;
  std::jthread carrier_;
};

}  // namespace roadbalance::test
