#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/types/scan.hpp"
#include "host/analysis/angle/angle_smoother.hpp"
#include "host/analysis/angle/mark_place.hpp"

namespace roadbalance {

/// A wheel's angle from the recorded messages of a pulse counter on the bus and the recorded zero marks of an
/// encoder line: what the node computes live (CounterEncoder), again and better, as it may look at both sides
/// of every instant (AngleSmoother) and has all marks from the begin.
///
/// Where in a turn the mark lies is learned for each run of the counter: the circular mean of its marks
/// without those that lie elsewhere.  Where most marks before agree on one place and most behind on another,
/// the control unit lost counts, and another run begins.  A run without marks, or whose marks contradict one
/// another, has no angle, only an angle turned through.
class RecordedCounter {
 public:
  /// @param counter  of the vehicle's signals, whose samples these are; in order of time
  /// @param edges    of the encoder line; only zero marks count; in order of time
  RecordedCounter(const EncoderConfig& config, const SignalConfig& counter,
                  std::span<const SignalSample> samples, std::span<const Edge> edges);

  /// Angles at first + i * step_ns (conventions.md), continuous over the call, not reduced to a turn.  False
  /// if not all are known.  Fast where calls go forward in time.
  [[nodiscard]] bool angles(NodeTime first, double step_ns, std::span<double> angle_rad);

  /// The same from an arbitrary origin, another in each run: how far the wheel has turned.
  [[nodiscard]] bool turned(NodeTime first, double step_ns, std::span<double> angle_rad);

  /// Standard deviation of an angle of the last call that was true, all causes but the datum.
  double sigma_rad() const { return sigma_rad_; }
  /// The part of it that is the same all through a drive: the place of the mark, and the latency at other
  /// speeds than the marks'.  Over the whole drive; nothing: no run has a mark.
  std::optional<double> common_sigma_rad() const;

  std::int64_t runs() const { return static_cast<std::int64_t>(runs_.size()); }
  std::int64_t marks() const;          ///< used
  std::int64_t marks_dropped() const;  ///< that lay elsewhere

 private:
  struct Run {
    std::vector<WheelPoint> points;  ///< pulses
    bool placed = false;
    double place = 0.0, place_sigma = 0.0;  ///< of the mark, pulses
    double mark_rate_hz = 0.0;              ///< mean, of the counter at the marks
    std::int64_t marks = 0, dropped = 0;
  };
  struct Marks {
    std::vector<PlacedMark> mark;
    double noise = 0.0;         ///< mean variance of their positions, pulses^2
    double bandwidth_hz = 0.0;  ///< mean, of the smoother at them
    double widest = 0.0;        ///< pulses; marks further from their place than this are of another
  };
  void drop_short_runs();
  void unwrap(std::span<const SignalSample> samples);
  Marks marks_of(const Run& run, std::span<const Edge> edges);
  void split(std::size_t run, std::span<const Edge> edges);
  void place_marks(Run& run, std::span<const Edge> edges);
  const Run* prepare(std::int64_t from_ns, std::int64_t to_ns);
  bool smooth(const Run& run, std::int64_t from_ns, std::int64_t to_ns);
  double rate_hz(const Run& run, std::int64_t time_ns) const;
  const Run* look_up(NodeTime first, double step_ns, std::span<double> angle_rad);

  EncoderConfig config_;
  SignalConfig counter_;
  std::vector<Run> runs_;

  // The stretch that was asked for last.
  AngleSmoother smoother_;
  const Run* smoothed_ = nullptr;
  std::int64_t from_ns_ = 0, to_ns_ = 0;
  double noise_ = 0.0;  ///< variance of a message, pulses^2
  double sigma_rad_ = 0.0;
};

}  // namespace roadbalance
