#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/angle/pitch_table.hpp"
#include "host/analysis/angle/angle_smoother.hpp"
#include "host/analysis/angle/number_teeth.hpp"

namespace roadbalance {

/// The wheel's angle (common/vehicle/conventions.md) from the edges of a whole recorded drive: what the live
/// encoder computes, again and better, as it may look at both sides of every instant.
///
/// The pitch table and the place of the zero mark are learned from the whole drive first, so that its begin
/// is as good as its end.  Where the wheel stood, turned backwards or had no zero mark, there is no angle. A
/// ring without a zero mark gives how far the wheel has turned, ring errors and all.
class RecordedAngle {
 public:
  RecordedAngle(const EncoderConfig& config, std::span<const Edge> edges);

  /// Angles at first + i * step_ns, continuous over the call, not reduced to a turn.  False if not all are
  /// known.  Fast where calls go forward in time.
  [[nodiscard]] bool angles(NodeTime first, double step_ns, std::span<double> angle_rad);

  /// The same of a ring without zero mark, from an arbitrary origin, another in each run.
  [[nodiscard]] bool turned(NodeTime first, double step_ns, std::span<double> angle_rad);

  /// Some instant of [first, last] lies in a turn without exactly its teeth.
  bool uncertain(NodeTime first, NodeTime last) const;
  /// Standard deviation of an angle of the last call; the datum is not in it.
  double sigma_rad() const;

  /// The part of it that is the same all through the drive: the place of the mark.
  double common_sigma_rad() const;

  const PitchTable& pitch_table() const { return table_; }
  const NumberedTeeth& teeth() const { return numbered_; }

 private:
  void learn_table();
  void learn_place();
  bool look_up(NodeTime first, double step_ns, std::span<double> angle_rad);
  bool prepare(std::int64_t from_ns, std::int64_t to_ns);
  std::vector<WheelPoint> points(const NumberedRun& run, std::int64_t from_ns, std::int64_t to_ns) const;

  const EncoderConfig config_;
  NumberedTeeth numbered_;
  PitchTable table_;
  double place_ = 0.0, place_sigma_ = 0.0;  ///< of the mark after tooth 0, pitches

  // The stretch that was asked for last.
  AngleSmoother smoother_;
  std::int64_t from_ns_ = 0, to_ns_ = 0;
  double sigma_ = 0.0;
};

}  // namespace roadbalance
