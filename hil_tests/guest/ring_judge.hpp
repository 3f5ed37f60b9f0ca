#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/types/blocks.hpp"
#include "common/types/scan.hpp"
#include "hil_tests/guest/ring_program.hpp"

namespace roadbalance::test {

/// A played ring, and where what was read of it is to be found.
struct JudgedRing {
  RingProgram program;
  std::uint8_t line = 0;  ///< of the node
  EncoderConfig encoder;
  FilterConfig filter;
  std::int64_t machine_minus_monotonic_ns = 0;

  std::int64_t monotonic_ns(NodeTime time) const { return to_ns(time) - machine_minus_monotonic_ns; }
};

/// Turns from one zero mark that was read to the next.
struct TurnVerdict {
  int whole = 0;     ///< have exactly their teeth
  int declared = 0;  ///< have not, and the encoder doubts it or gives no angle, or there is a kLost edge
  int silent = 0;    ///< have not, without a flag
  std::string text() const;
};
/// @param edges  of all lines, in order of time, as they were read
TurnVerdict judge_turns(std::span<const Edge> edges, const JudgedRing& ring);

/// Scans against the true angle, passed through the filter: right is within half a pitch and what is allowed.
struct AngleVerdict {
  std::int64_t right = 0;          ///< and not flagged
  std::int64_t flagged = 0;        ///< unknown, settling or uncertain, right or wrong
  std::int64_t flagged_wrong = 0;  ///< of these: an angle is given, and it is wrong
  std::int64_t silent_wrong = 0;   ///< wrong, without a flag
  /// Angles without a flag that are judged to less than a whole pitch, so that a tooth too many or too few
  /// shows.
  std::int64_t strict = 0;
  double worst_silent_pitches = 0.0;
  std::string text() const;
};
/// @param allowed_pitches  more than half a pitch at this instant of CLOCK_MONOTONIC: what the player is late
/// @param blocks           scans while the ring turns
AngleVerdict judge_angles(std::span<const ScanBlock> blocks, const JudgedRing& ring,
                          const std::function<double(std::int64_t monotonic_ns)>& allowed_pitches);

/// The block flags its angle of this line as unknown, settling or uncertain.
bool is_flagged(const ScanBlock& block, std::uint8_t line);

}  // namespace roadbalance::test
