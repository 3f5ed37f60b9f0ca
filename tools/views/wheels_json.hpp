#pragma once

#include <array>
#include <nlohmann/json.hpp>

#include "common/bus/results.hpp"
#include "sim/truth.hpp"

namespace roadbalance {

/// The "wheels" of rb demo and rb identify: one object a wheel, null where a value is not known.
/// covariance_g2 is [2 x 2] of the components of unbalance_g along and across the zero mark (cos, sin of
/// angle_deg); force_n is that which does not grow with speed, if force_state is "separated" and not
/// "not_separable" or "not_judged". The same estimate gives the same text, wherever it comes from.
nlohmann::ordered_json wheels_json(const Identification& identification,
                                   const std::array<Balance, kWheels>& balance);

/// Adds truth_g, truth_deg and truth_tyre_stiffness_n_m to each.
void add_truth(nlohmann::ordered_json& wheels, const sim::Truth& truth);

}  // namespace roadbalance
