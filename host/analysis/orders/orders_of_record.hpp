#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/analysis/angle/angle_reprocessor.hpp"
#include "host/analysis/orders/crossing_orders.hpp"
#include "host/analysis/orders/rotor_orders.hpp"
#include "host/recording/read_recording.hpp"

namespace roadbalance {

struct WantedOrders {
  std::optional<std::string> wheel{};  ///< nothing, and no rotor: every wheel of which anything is known
  std::optional<std::string> rotor{};  ///< of vehicle.toml, instead
  /// A channel of any node, those that read the encoders first; nothing: every acceleration.
  std::optional<std::string> channel{};
  bool all_nodes = false;  ///< accelerations of all nodes, not only of those that read the encoders
  std::vector<double> order{1.0, 2.0};
  /// Of a block: MeanVector needs six of them; the least order is one period in a block.
  int block_turns = RotorOrders::kVectorTurns;
  /// Also all wheels together by the Vold-Kalman filter of this bandwidth, Hz; nothing: not.
  std::optional<double> vold_kalman_hz{};
};

struct RecordOrders {
  VehicleConfig vehicle;  ///< as it was recorded
  /// At least one; for each rotor one for each node whose channels are wanted.
  std::vector<std::unique_ptr<RotorOrders>> rotor{};
  /// With WantedOrders::vold_kalman_hz one for each node whose channels are wanted: of all wheels whose angle
  /// is known against a zero mark, and the rotor if one is wanted.
  std::vector<std::unique_ptr<CrossingOrders>> crossing{};
  /// Quality of the angles that were computed from the bus, by place in VehicleConfig::wheel.
  std::map<int, AngleReprocessor::Quality> angle{};
  RecordingDefects defects{};
};

/// Orders in a finished recording.
///
/// Angles of wheels whose teeth are counted on the bus are computed again (AngleReprocessor), and all angles
/// where a wheel has a tachometer of one pulse a turn, of which the live encoder needs some turns to begin;
/// for one whose
/// zero marks do not show where it stands it is counted how far it has turned, and Rotor::known_share is 0.
/// A wheel without an encoder whose speed is on the bus is analysed in the node that hears it, by how far it
/// has turned: Quality::by_speed.  Then only spectra hold, for the turns run away from the wheel.  Each rotor
/// is analysed in each node for itself, and decodes and aligns the blocks of its nodes for itself.  Where a
/// node is behind or stays away every analysis with it holds GridJoin::kLongestWait_s of the others.
/// @throws ConfigError naming a wheel, rotor, channel or order that cannot be analysed, and what can; else as
///         read_recording
RecordOrders orders_of_record(const std::filesystem::path& folder, const WantedOrders& wanted);

}  // namespace roadbalance
