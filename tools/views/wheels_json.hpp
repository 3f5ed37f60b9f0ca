#pragma once

#include <array>
#include <nlohmann/json.hpp>

#include "common/bus/results.hpp"
#include "sim/truth.hpp"

namespace roadbalance {

/// The "wheels" of rb demo and rb identify: one object a wheel, null where a value is not known.
/// covariance_g2 is [2 x 2] of the components of unbalance_g along and across the zero mark (cos, sin of
/// angle_deg).  unbalance_g is the correction; alone_g the unbalance alone and force_n the tyre's force, which
/// does not grow with speed, null if force_state is "not_judged"; "not_separable": the speeds driven hardly
/// tell them apart, and sigma_alone_g and sigma_force_n are wide.  The same estimate gives the same text,
/// wherever it comes from.
nlohmann::ordered_json wheels_json(const Identification& identification,
                                   const std::array<Balance, kWheels>& balance);

/// Adds truth_g, truth_deg and truth_tyre_stiffness_n_m to each.
void add_truth(nlohmann::ordered_json& wheels, const sim::Truth& truth);

}  // namespace roadbalance
