#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/angle/pitch_table.hpp"
#include "common/angle/tooth_history.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/types/scan.hpp"

namespace roadbalance {

/// A stretch of time in which the wheel turned forward without a stop.
struct NumberedRun {
  std::vector<NumberedTooth> teeth;    ///< tooth 0 is the one nearest to a zero mark
  std::vector<std::int64_t> marks_ns;  ///< zero marks that count
};

/// The numbers of a drive's teeth by its edges.
struct NumberedTeeth {
  std::vector<NumberedRun> runs;  ///< of those that have a zero mark; all, of a ring without one
  struct Turn {
    std::int64_t from_ns, to_ns;
  };
  std::vector<Turn> faulty_turns;  ///< mark to mark, without exactly their teeth; in order
  std::int64_t marks_dropped = 0;  ///< doubled, late or false
  /// The marks name no tooth: the teeth counted between them (MarkCount), and there are no runs.
  std::array<int, 2> mark_counts{};
  std::int64_t slips = 0;  ///< turns in which the count of teeth went wrong and was put right
};

/// Numbers every pulse of a drive by the zero marks, looking at both sides of each.
///
/// Pulses are followed tooth by tooth (ToothTracker), marks are placed among them.  A mark that stands alone
/// against those around it is dropped; where the marks agree from one on that the count is off, the turn
/// before it is numbered by a piecewise cubic through the marks and declared faulty.  So no slip outlives its
/// turn.  Runs without a zero mark, or whose marks name no tooth, give no angle and are left out.  Without a
/// zero mark on the ring, each run is numbered from a tooth of its own.
NumberedTeeth number_teeth(const EncoderConfig& config, std::span<const Edge> edges);

/// The same once the ring's errors are known: a pulse is then distinguished from its neighbours though errors
/// and jitter together are half a pitch.
/// @param table    of the teeth as `earlier` numbers them
/// @param earlier  the result for the same edges without it
NumberedTeeth number_again(const EncoderConfig& config, std::span<const Edge> edges, const PitchTable& table,
                           const NumberedTeeth& earlier);

}  // namespace roadbalance
