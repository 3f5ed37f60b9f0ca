#pragma once

#include <cstdint>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/types/scan.hpp"
#include "sim/drive.hpp"
#include "sim/random.hpp"
#include "sim/scenario.hpp"

namespace roadbalance::sim {

/// Edges not yet handed over, in order of stamp.  Its room is made once.
class EdgeQueue {
 public:
  explicit EdgeQueue(std::size_t room) { edge_.reserve(room); }

  void insert(const Edge& edge);
  bool due(NodeTime until) const { return first_ < edge_.size() && edge_[first_].time <= until; }
  Edge take();

 private:
  std::vector<Edge> edge_;
  std::size_t first_ = 0;  ///< those before are taken
};

/// The encoder of one wheel: an edge a tooth, an edge a turn for the zero mark.
///
/// Encoder angle = wheel angle - datum.  The zero mark fires at encoder angle 0; tooth n at
/// 2 pi (n + offset) / N + error[n mod N], error of zero mean, drawn by seed and wheel, plus a once-a-turn
/// part if the ring sits off centre.  Stamps jitter by a pure function of the edge's number.
class ToneWheel {
 public:
  /// Instant and motion of the car.
  struct Instant {
    double time_s;
    Motion motion;
  };

  /// @param zero_angle_rad  wheel angle at position 0
  /// @param start           edges come after it
  ToneWheel(const EncoderScenario& scenario, std::uint64_t seed, std::size_t wheel,
            const EncoderConfig& encoder, std::uint8_t line, double rolling_radius_m, double zero_angle_rad,
            const Instant& start);

  /// Adds every edge between two instants, between which the car's position is taken as cubic Hermite in
  /// time.
  void advance(const Instant& from, const Instant& to, EdgeQueue& queue);

  /// Encoder angle at which tooth n fires.
  double tooth_angle_rad(std::int64_t n) const;

 private:
  struct Kind {
    EdgeKind kind;
    RandomSequence jitter;
    std::int64_t number;  ///< of the next edge
  };
  double angle_rad(const Kind& kind) const;
  void advance(Kind& kind, const Instant& from, const Instant& to, EdgeQueue& queue);

  std::int64_t pulses_;
  bool zero_mark_;
  std::uint8_t line_;
  double radius_m_;
  double zero_angle_rad_;  ///< encoder angle at position 0
  double jitter_s_;
  std::vector<double> position_rad_;  ///< of tooth 0 .. N - 1
  Kind tooth_, mark_;
};

}  // namespace roadbalance::sim
