#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/record/record_state.hpp"
#include "common/types/block.hpp"
#include "host/recording/recover/sequence_set.hpp"

namespace roadbalance {

/// Signals of the car in a recording, for each node epoch.
class SignalSurvey {
 public:
  /// Contents of one signal; node times.
  struct Signal {
    std::int64_t samples = 0;
    std::int64_t first_ns = 0, last_ns = 0;
    double first = 0.0, last = 0.0, least = 0.0, greatest = 0.0;
  };

  /// Takes an event of the record; what is no signal block, or one that came before, is passed over.
  void add(std::string_view channel, std::span<const std::uint8_t> data);
  /// The same of a block that was accepted.
  void add(const SealedBlock& block);

  /// By number, as vehicle.toml counts them.
  const std::map<int, Signal>& of(NodeEpoch key) const;
  const std::map<NodeEpoch, std::map<int, Signal>>& all() const { return signals_; }

 private:
  std::map<NodeEpoch, std::map<int, Signal>> signals_;
  std::map<NodeEpoch, SequenceSet> seen_;
};

/// For programs: an object for each signal of each node epoch.
/// @param vehicle  as the record describes it; nullptr: it does not, and signals have numbers only
nlohmann::ordered_json signals_json(const SignalSurvey& survey, const VehicleConfig* vehicle);

/// For people: a line for each signal of a node epoch.
std::vector<std::string> signal_lines(const SignalSurvey& survey, NodeEpoch key,
                                      const VehicleConfig* vehicle);

}  // namespace roadbalance
