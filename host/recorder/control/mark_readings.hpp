#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "common/bus/operation.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/clocks.hpp"
#include "host/analysis/calibration/datum_readings.hpp"
#include "host/analysis/calibration/line_edges.hpp"

namespace roadbalance {

/// Operation::kReading: where a wheel's zero mark fires, by turning the wheel by hand while a recording is
/// under way, for only then a node sends its edges.  One wheel at a time.  A pure state machine of bounded
/// memory.
///
/// A reading is a note in the recording, and the answer has the datum so far; between recordings
/// Operation::kDatum sets it.  A recorder that is killed has forgotten the readings.
///
/// A reading counts when no edge has come for kStill before it: edges travel up to half a second, and a wheel
/// that still turns is not where it was read.
class MarkReadings {
 public:
  static constexpr std::chrono::milliseconds kStill{1200};
  static constexpr std::size_t kMost = 100;

  /// Whether blocks matter now.
  bool listens() const { return wheel_.has_value(); }
  /// A block that accept() took.
  void take(const SealedBlock& block, WallTime now);
  /// No recording is under way any more.
  void forget() { wheel_.reset(); }

  /// The whole answer but for its time.
  Answer take(const Request& request, const VehicleConfig& vehicle, WallTime now);

 private:
  struct Wheel {
    int place;  ///< in VehicleConfig::wheel
    std::string name, node;
    LineEdges line;
    DatumReadings readings;
    std::int32_t node_id;
    WallTime still_since, heard;  ///< its newest edge, its node's newest block
  };
  Answer begin(Answer answer, const VehicleConfig& vehicle, int place, WallTime now);
  Answer read(Answer answer, double angle_rad, WallTime now);

  std::optional<Wheel> wheel_;
};

/// The wheel of a request about zero marks.
/// @throws ConfigError if it is none that has one
const WheelConfig& wheel_with_mark(const VehicleConfig& vehicle, int place);

}  // namespace roadbalance
