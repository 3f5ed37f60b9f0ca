#pragma once

#include <cstdint>
#include <vector>

#include "host/analysis/angle/number_teeth.hpp"

namespace roadbalance {

/// A run of pulses followed tooth by tooth; its count may have slipped.
struct FollowedRun {
  std::vector<NumberedTooth> teeth;     ///< in order of time, numbers growing
  std::vector<std::int64_t> marks_ns;   ///< as they came
  std::vector<std::int64_t> faults_ns;  ///< where a pulse was missing or too many
};

/// A zero mark among the followed teeth.
struct ChainedMark {
  std::int64_t time_ns;
  double position;    ///< by the count of teeth
  std::int64_t slip;  ///< of the count since the first mark
  std::int64_t turn;  ///< since the first mark
};
struct MarkChain {
  std::vector<double> placed;  ///< positions of all marks, those that were dropped, too
  std::vector<ChainedMark> marks;
  std::int64_t dropped = 0;
  std::int64_t slips = 0;  ///< marks from which on the count is off by more than at the one before
};

/// The marks that agree with each other, each at a whole number of turns and known slips from the one before.
MarkChain chain_marks(const FollowedRun& run, int teeth);

/// Numbers the teeth from the marks.
/// @param place  of the mark after the tooth that it names, pitches
NumberedRun anchor_run(const FollowedRun& run, const MarkChain& chain, int teeth, double place);

/// Adds the turns of the run in which a pulse was missing or too many, or the count slipped.
void declare_faulty_turns(const FollowedRun& run, const MarkChain& chain,
                          std::vector<NumberedTeeth::Turn>& turns);

}  // namespace roadbalance
