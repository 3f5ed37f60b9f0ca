#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/orders/grid_join.hpp"
#include "host/analysis/orders/rotor.hpp"

namespace roadbalance {

/// The node of the channels first, then those that read the encoders of the rotors' wheels.
/// @param node  a place in VehicleConfig::node
std::vector<const NodeConfig*> nodes_of(const VehicleConfig& vehicle, std::span<const Rotor> rotors,
                                        int node);

/// Where a rotor stands, by the references of its wheels in the rows of such nodes.
class RotorAngle {
 public:
  enum class State {
    kKnown,
    kNotKnown,   ///< a node did not have its wheel's angle
    kUncertain,  ///< known, but a turn did not have exactly its teeth
  };
  struct Reading {
    State state;
    double angle_rad;  ///< unwrapped from where the wheels were after the last forget(); kNotKnown: 0
  };

  /// @param nodes  as nodes_of() gives them
  RotorAngle(const VehicleConfig& vehicle, const Rotor& rotor, const std::vector<const NodeConfig*>& nodes);

  Reading read(const GridJoin::Row& row);
  /// As far as the nodes report it; read() looks at the references, too.
  State state(const GridJoin::Row& row) const;
  /// Turns are counted from the next reading on.
  void forget();

 private:
  struct Wheel {
    std::size_t node;  ///< of the rows
    int line;
    std::optional<double> angle_rad{};  ///< unwrapped, of the row before
  };
  double ratio_;
  std::vector<Wheel> wheel_;
};

}  // namespace roadbalance
