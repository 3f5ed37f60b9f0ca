#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hil_tests/deterministic/datagram_pool.hpp"
#include "hil_tests/deterministic/event_queue.hpp"
#include "hil_tests/deterministic/fault_scenario.hpp"
#include "hil_tests/deterministic/random.hpp"

namespace roadbalance::test {

/// The bus between nodes and recorders: every datagram is lost, doubled or late on its own on the way to each
/// who listens.
class Network {
 public:
  Network(const FaultScenario& scenario, std::uint64_t seed, EventQueue& events)
      : scenario_(scenario), random_(seed, 0), events_(events) {}

  /// Nodes listen to acknowledgements and commands of their number.
  void add_node(std::int32_t number);
  void from_node(std::size_t node, const std::string& channel, std::span<const std::uint8_t> bytes,
                 std::int64_t now_ns);
  void from_host(std::size_t host, const std::string& channel, std::span<const std::uint8_t> bytes,
                 std::int64_t now_ns);
  void from_asker(const std::string& channel, std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  /// The cable between a node and the others.
  void pull(std::size_t node, Direction direction, bool out);

  /// An exchange of stamps between a recorder and a node comes through.
  bool exchange(std::size_t node);

  DatagramPool& datagrams() { return datagrams_; }
  std::int64_t blocks_sent() const { return blocks_sent_; }

 private:
  struct Cable {
    std::string ack, command, vehicle;
    std::array<int, 2> out{};  // [to host, to node], counts of faults under way
  };
  int copies(double loss);
  void arrive(Event::Kind kind, std::size_t who, std::uint32_t datagram, int copies, std::int64_t now_ns);

  const FaultScenario& scenario_;
  Random random_;
  EventQueue& events_;
  DatagramPool datagrams_;
  std::vector<Cable> cables_;
  std::int64_t blocks_sent_ = 0;
};

}  // namespace roadbalance::test
