#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/angle/pitch_table.hpp"
#include "common/angle/tooth_history.hpp"

namespace roadbalance {

/// Finds which tooth is which by the errors of the ring itself, where the count was lost and no zero mark has
/// come since.
///
/// The deviation of each of at least a turn of teeth from a cubic through the eight on either side is
/// compared with that of the table, for every way to lay the one on the other.  A match is accepted only if
/// it is e^20 times as likely as the next, and fits as well as the teeth's noise lets expect: an even wheel,
/// one that repeats itself, or a different one is refused.  Wheels of at most kMostTeeth.  Never allocates
/// after construction.
class PitchPattern {
 public:
  static constexpr int kBeside = 8, kMostTeeth = 256, kMostTurns = 4;

  explicit PitchPattern(int teeth);

  /// The number, among those of `history`, of a tooth that the table calls 0; or nothing.
  std::optional<std::int64_t> find_origin(const ToothHistory& history, const PitchTable& table) noexcept;

 private:
  bool observe(const ToothHistory& history) noexcept;
  double misfit(std::size_t shift) const noexcept;

  const std::size_t teeth_;
  std::vector<double> seen_;      ///< mean of what teeth with this number modulo teeth_ lie off, pitches
  std::vector<double> weight_;    ///< how many
  std::vector<double> expected_;  ///< of a tooth of the table
  double noise_ = 0.0;            ///< variance of one of them
};

}  // namespace roadbalance
