#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/analysis/balance/overall_plan.hpp"

namespace roadbalance {

/// Text of rb identify --overall: the weights of each wheel, and the vibration of the seats at each speed and
/// over all of them as it is, with each wheel balanced for itself, and with these weights; last the wheels
/// that are missing in that.
std::vector<std::string> overall_lines(const OverallPlan& plan);

/// The same as an object: "seats", "wheels", "speeds" and "all".
nlohmann::ordered_json overall_json(const OverallPlan& plan);

}  // namespace roadbalance
