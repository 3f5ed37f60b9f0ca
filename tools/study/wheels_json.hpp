#pragma once

#include <array>
#include <nlohmann/json.hpp>

#include "common/bus/results.hpp"
#include "sim/truth.hpp"

namespace roadbalance {

/// The "wheels" of rb demo and rb identify: one object a wheel, null where a value is not known; force_n is
/// that which does not grow with speed, if the speeds tell it apart. The same estimate gives the same text,
/// wherever it comes from.
nlohmann::ordered_json wheels_json(const Identification& identification,
                                   const std::array<Balance, kWheels>& balance);

/// Adds truth_g, truth_deg and truth_tyre_stiffness_n_m to each.
void add_truth(nlohmann::ordered_json& wheels, const sim::Truth& truth);

}  // namespace roadbalance
