#pragma once

#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "host/analysis/balance/influence.hpp"

namespace roadbalance {

/// What an instrument showed of one channel in a run.
struct Reading {
  std::complex<double> vector;  ///< amplitude at its phase
  double digits_variance;       ///< of both parts together, by the last digits that were written down
  std::optional<double> sigma;  ///< of each part, as somebody stated it
};

/// A table of runs with known weights, from any instrument.  Angles of weights and phases count in the same
/// direction from the same mark.
struct Readings {
  std::vector<std::string> plane, channel;
  struct Run {
    std::string name;
    std::optional<double> speed;               ///< in any unit; nothing: that of all others
    std::vector<std::complex<double>> weight;  ///< [plane]
    std::vector<Reading> reading;              ///< [channel]
  };
  std::vector<Run> run;
};

/// Weights by readings, and how far they can be trusted.
struct ReadingsBalance {
  std::string refusal;              ///< why there are no weights, and what would help; empty: there are
  std::vector<std::string> remark;  ///< for people
  std::vector<std::string> used;    ///< runs, by name
  struct OtherSpeed {
    std::string run;
    double speed;
  };
  std::vector<OtherSpeed> other_speed;  ///< runs that are not used, as they cannot be compared
  std::optional<double> speed;          ///< mean of the used runs
  int beyond = 0;                       ///< runs beyond those needed, whose scatter gives the uncertainty
  std::vector<PlaneCorrection> plane;   ///< to put on the bare rotor
  InfluenceBalance balance;             ///< valid if there is no refusal
  /// [plane] rms that would be left with no weight in that plane, and the best ones in the others; of one
  /// plane empty.
  std::vector<double> rms_without;
};

/// Balances by influence coefficients (balance_by_influence) the runs of one speed.
///
/// One speed: all speeds within kSameSpeed of that of one run, which is the one nearest to `speed`, or else
/// the one with the most such runs.  An influence holds for its speed only.
///
/// The variance of a reading is the stated one; else the larger of that of its channel's fewest digits and,
/// where there are runs beyond those needed, of the scatter of the runs about the fit, in that channel
///
///     s^2 = sum |observed - bare - influence weight|^2 / (runs - planes - 1)
///
/// with Student's factor for so few.  Digits alone are the least that it can be: it is remarked on.
ReadingsBalance balance_readings(const Readings& readings, std::optional<double> speed = std::nullopt);

inline constexpr double kSameSpeed = 0.01;       ///< share of it
inline constexpr double kAlikeFrom = 10.0;  ///< from this condition number on it is remarked on

}  // namespace roadbalance
