#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <queue>
#include <random>
#include <string>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/link/receiver.hpp"
#include "common/link/ring.hpp"
#include "common/link/sender.hpp"

namespace roadbalance::test {

struct LinkScenario {
  double seconds = 10;
  double loss = 0;
  double duplicates = 0;
  double reordered = 0.02;
  double cable_out_s = -1;  ///< pulled here ...
  double cable_in_s = -1;   ///< ... and plugged in here
  int recorder_kills = 0;
  int node_kills = 0;
  double slow_syncs = 0;  ///< share of syncs that take 0.5 to 3 s
  std::size_t ring_bytes = Ring::kDefaultBytes;
};

struct LinkOutcome {
  std::int64_t sealed = 0;    ///< blocks, all epochs
  std::int64_t recorded = 0;  ///< blocks found on the disk, unaltered, once
  std::int64_t declared = 0;  ///< blocks of killed nodes' memory, inside a crash gap
  std::int64_t transmissions = 0;
  double longest_to_durable_s = 0;
  double drained_after_s = 0;       ///< from the end of production until everything was freed
  std::vector<std::string> faults;  ///< broken promises: none are allowed
};

/// One node and one recorder, made of the product's Sender, Receiver and Ring, under a network, a disk and
/// kills that are a pure function of scenario and seed.  Time is simulated; nothing waits.
class LinkSimulation {
 public:
  LinkSimulation(const LinkScenario& scenario, std::uint64_t seed) : scenario_(scenario), random_(seed) {}

  LinkOutcome run();

 private:
  using Action = std::function<void()>;
  struct Event {
    std::int64_t time_us;
    std::int64_t order;
    Action action;
    bool operator<(const Event& other) const {
      return time_us != other.time_us ? time_us > other.time_us : order > other.order;
    }
  };
  struct Disk {
    std::map<std::int64_t, std::map<std::int64_t, Delivery>>
        epoch;  // [epoch][sequence], what survives a kill
  };
  struct Node {
    explicit Node(std::int64_t number, std::size_t ring_bytes)
        : epoch(number), ring(ring_bytes), backlog(ring), sender(backlog, 1, number) {}
    std::int64_t epoch;
    Ring ring;
    Backlog backlog;
    Sender sender;
  };

  void after_ms(double ms, Action action);
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  WallTime now() const { return WallTime(std::chrono::microseconds(time_us_)); }
  void network(Action arrive);

  void boot_node();
  void produce();
  void pump();
  void beat();
  void boot_recorder();
  void take_up(const std::function<void(std::vector<Delivery>&)>& input);
  void acknowledge();
  void sync();
  void claim();
  void kill_recorder();
  void kill_node();
  void store(const Delivery& delivery);
  void check_freed();
  void check_record(LinkOutcome& outcome);
  void fault(const std::string& what);

  const LinkScenario scenario_;
  std::mt19937_64 random_;
  std::priority_queue<Event> events_;
  std::int64_t time_us_ = 0;
  std::int64_t order_ = 0;
  bool producing_ = true;

  std::optional<Node> node_;
  std::int64_t epochs_ = 0;
  std::optional<Receiver> receiver_;
  std::int64_t incarnation_ = 0;
  std::vector<Delivery> written_;  // not yet synced
  bool syncing_ = false;
  Disk disk_;
  std::map<std::int64_t, std::map<std::int64_t, std::pair<SealedBlock, std::int64_t>>>
      truth_;  // with time sealed
  std::int64_t transmissions_before_ = 0;
  LinkOutcome outcome_;
};

}  // namespace roadbalance::test
