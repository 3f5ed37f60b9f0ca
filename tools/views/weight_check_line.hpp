#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/bus/weight_check.hpp"

namespace roadbalance {

/// The effect of weights on a wheel, for people: "before 35.0 g, now 2.1 g: 94 % less, ± 3 %; good; ...".
std::string weight_check_line(const WeightCheck& check);

nlohmann::ordered_json weight_check_json(const WeightCheck& check);

}  // namespace roadbalance
