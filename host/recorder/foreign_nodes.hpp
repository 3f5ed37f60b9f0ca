#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/control.hpp"
#include "common/clock/clocks.hpp"

namespace roadbalance {

/// Knows the nodes that obey another recorder, and says so once of each; a pure state machine.
///
/// A node obeys a dead recorder until its lease is over, which is no news: it counts as another's after
/// kPatience.
class ForeignNodes {
 public:
  void take(const Heartbeat& heartbeat, std::int64_t our_incarnation, WallTime now);

  /// Those that obey another recorder now.
  std::vector<std::int32_t> nodes() const;
  /// For people, since the last call.
  std::vector<std::string> sentences() { return std::exchange(sentences_, {}); }

  static constexpr std::chrono::seconds kPatience{3};

 private:
  struct Node {
    WallTime since{};
    WallTime heard{};
    bool told = false;
  };
  std::map<std::int32_t, Node> nodes_;
  std::vector<std::string> sentences_;
};

}  // namespace roadbalance
