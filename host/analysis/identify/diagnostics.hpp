#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/bus/results.hpp"

namespace roadbalance {

/// Sentences for the driver: what an estimate rests on, where the car is not as it was described, and what
/// would help more.  None while nothing is known.
///
/// Their chances are those of a drive that is judged once, at its end: what comes and goes while it
/// goes on is no more than that.
std::vector<std::string> diagnostics(const Identification& identification,
                                     const std::array<Balance, kWheels>& balance);

/// A model that fits shows a misfit as large by chance in so many drives, each judged once.
inline constexpr double kMisfitChance = 1e-3;

/// Words for what does not fit, e.g. "front_left, body"; empty: all does.
std::string misfitting(const Identification& identification);

}  // namespace roadbalance
