#pragma once

#include <optional>

#include <Eigen/Core>

#include "host/analysis/identify/signals.hpp"

namespace roadbalance {

/// True if the wheel's angle was known all through.
/// @param signals  [kSignals x samples]
bool has_reference(const Eigen::Ref<const SignalMatrix>& signals, int wheel);

/// Mean rotation rate of a wheel, rad/s, from its reference's phase; nothing if it lacks its angle somewhere.
/// @param signals  [kSignals x samples], at least two samples
std::optional<double> mean_rotation(const Eigen::Ref<const SignalMatrix>& signals, int wheel, double rate_hz);

}  // namespace roadbalance
