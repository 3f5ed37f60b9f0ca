#pragma once

#include <cstdint>
#include <vector>

#include "common/angle/tooth_history.hpp"

namespace roadbalance {

/// Where each tooth of a ring really sits, in pitches from its nominal place; learned while driving.
///
/// Over six turns the wheel's angle is a polynomial of order 5 in time; a tooth's difference from it,
/// averaged over many turns, is its pitch error (ENCODER: local order-5 polynomials over 6 turns).  Fast
/// motion of the wheel is not bound to the turn and averages out.  Eccentricity is an entry like any other.
class PitchTable {
 public:
  static constexpr int kTurns = 6;  ///< turns one polynomial spans

  explicit PitchTable(int teeth);

  /// For a tooth counted from the zero mark; any turn.
  double error_pitches(std::int64_t tooth) const noexcept { return trust_ * error_[place(tooth)]; }

  /// Learns from the six turns that begin with tooth number `first`; tooth numbers in `history` count from
  /// `origin`, the number of the tooth at the zero mark.  Does nothing if the turns are not all there.
  void learn(const ToothHistory& history, std::int64_t first, std::int64_t origin) noexcept;

  /// The teeth are those of another wheel, or it is not known which is which.
  void forget() noexcept;

  /// How many times the table was refined.
  int refinements() const noexcept { return refinements_; }
  /// Standard deviation of an entry, from the scatter of its residuals; pitches.  Infinite before learning.
  double sigma_pitches() const noexcept;

 private:
  std::size_t place(std::int64_t tooth) const noexcept {
    const auto n = static_cast<std::int64_t>(error_.size());
    const std::int64_t k = tooth % n;
    return static_cast<std::size_t>(k < 0 ? k + n : k);
  }
  void make_zero_mean() noexcept;
  void weigh() noexcept;

  std::vector<double> error_;
  std::vector<int> weight_;  ///< residuals in each mean, up to the limit from which old ones are forgotten
  int refinements_ = 0;
  double scatter_ = 0.0;  ///< mean square residual, pitches^2
  double trust_ = 0.0;    ///< 0 .. 1, share of the table that is applied
};

}  // namespace roadbalance
