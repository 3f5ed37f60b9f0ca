#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/types/scan.hpp"

namespace roadbalance::sim {

/// Edges of one encoder whose angle is any function of time, found by bracketing: independent of how the
/// product gets back from edges to angles.
///
/// The zero mark fires at whole turns, tooth n at first_tooth_rad + n pitches + pitch_error_rad[n mod teeth],
/// in either direction of rotation.
struct PulseTrain {
  std::function<double(double)> angle_rad;  ///< of seconds; zero mark at whole turns
  int teeth = 96;
  std::vector<double> pitch_error_rad = {};  ///< [teeth], or empty
  double first_tooth_rad = 0.02;             ///< angle from the zero mark to tooth 0
  double jitter_s = 0.0;                     ///< of every stamp, rms
  double lost = 0.0, extra = 0.0;            ///< share of teeth; an extra one comes anywhere up to the next
  bool second_track = false;                 ///< shows which teeth pass backwards
  std::uint64_t seed = 1;
  std::uint8_t line = 0;

  /// In order of stamp.  The angle must not turn back twice within 0.1 ms.
  std::vector<Edge> edges(double from_s, double to_s) const;

 private:
  double tooth_rad(std::int64_t n) const;
};

/// Independent errors of each tooth, of zero mean: the mean belongs to the place of tooth 0.
std::vector<double> pitch_errors(int teeth, double rms_rad, std::uint64_t seed);

/// `errors` and those of a ring mounted off centre: once a turn, `amplitude_rad`.
std::vector<double> with_eccentricity(std::vector<double> errors, double amplitude_rad, double phase_rad);

/// `errors` and those of a ring bent from a strip, whose joint (between the last tooth and the first) is
/// `share` of a pitch too wide.
std::vector<double> with_joint(std::vector<double> errors, double share);

}  // namespace roadbalance::sim
