#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/clock/clock_model.hpp"
#include "hil_tests/deterministic/asker.hpp"
#include "hil_tests/deterministic/event_queue.hpp"
#include "hil_tests/deterministic/fault_scenario.hpp"
#include "hil_tests/deterministic/host_machine.hpp"
#include "hil_tests/deterministic/network.hpp"
#include "hil_tests/deterministic/node_machine.hpp"
#include "hil_tests/deterministic/random.hpp"
#include "hil_tests/deterministic/run_result.hpp"
#include "hil_tests/deterministic/truth.hpp"

namespace roadbalance::test {

/// One run of a scenario: nodes, recorders, bus, disks, clocks and power, moved event by event.  A pure
/// function of scenario, seed and length; nothing waits, nothing asks the machine for the time.
class World {
 public:
  World(const FaultScenario& scenario, std::uint64_t seed, double seconds);
  ~World();

  RunResult run();
  /// After run(): the segments of each recorder as files, and truth.json for tools/check_record.py.
  void dump(const std::string& folder);

 private:
  struct Timed {
    const PlannedFault* fault;
    std::size_t target;  ///< node, or host
    double chance;       ///< for what the fault itself draws
  };
  struct Node {
    std::unique_ptr<NodeMachine> machine;
    std::deque<std::uint32_t> socket;  // while its link hangs
    std::int64_t turn_at_ns = 0;
    int down = 0;                     // faults that keep it off
    std::int64_t cleared_behind = 0;  // the last block sealed when the cable came back; 0: nothing to watch
    std::int64_t plugged_at_ns = 0;
    std::optional<ClockModel> clock;
    std::optional<ClockFit> fit;  ///< the last one that is known, of this clock
    bool fit_held = false;        ///< at its instant
    std::int64_t exchanges = 0;
    bool left = false;  // its program has ended in order
    bool ends = false;  // so it will, to be started again
  };
  void turn_asker(std::size_t which);
  void take_answer(const Event& event);
  bool was_named(std::int32_t node) const;
  void check_set_up();
  struct Host {
    std::unique_ptr<HostMachine> machine;
    std::deque<std::uint32_t> socket;
    std::int64_t turn_at_ns = 0;
    int down = 0;
  };

  void plan(const PlannedFault& fault, std::int64_t& last_ns);
  void handle(const Event& event);
  void arrive_at_node(const Event& event);
  void arrive_at_host(const Event& event);
  void turn_node(std::size_t which);
  void turn_host(std::size_t which);
  void wake_node(std::size_t which, std::int64_t at_ns);
  void wake_host(std::size_t which, std::int64_t at_ns);
  void boot_node(std::size_t which);
  void boot_host(std::size_t which);
  void turn_fault(const Timed& timed, bool on);
  void turn_node_fault(const Timed& timed, std::size_t node, bool on);
  void end_node(const Timed& timed, Node& node, bool on);
  void turn_death(const Timed& timed, Host& host, bool on);
  void turn_host_fault(const Timed& timed, bool on);
  void exchange_stamps(std::size_t node);
  void drain_sockets();
  void watch_pull(Node& node);
  void check_finished();
  void check_absences();
  bool is_over() const;
  void fault_not_over(std::int64_t waited_ns);
  RunResult result();

  const FaultScenario& scenario_;
  const std::int64_t production_ns_;
  Random random_;
  Truth truth_;
  EventQueue events_;
  Network network_;
  std::vector<Node> nodes_;
  std::vector<Host> hosts_;
  std::vector<Asker> askers_;
  std::int64_t quiet_since_ns_ = 0;  // the operated recorder has nothing to do
  std::vector<Timed> faults_;
  std::int64_t now_ns_ = 0;
  bool stopped_ = false;
  std::int64_t stopped_ns_ = 0;
  double longest_pull_cleared_s_ = 0;
  std::int64_t kills_ = 0;  // of recorders that had begun, by power cuts too
  std::int64_t clock_windows_ = 0;
  std::int64_t clock_covered_ = 0;
};

}  // namespace roadbalance::test
