#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

namespace roadbalance {

/// Error of the identified unbalances by a drift of the speed: one car on one road, once drifting by 5
/// km/h a minute for 320 s, once in eight steps of 40 s over the same speeds.
///
/// Four unbalances of 60 g, and a road smoother than class A, so that chance is small against what is looked
/// for.
/// @param folder  for the two drives' scenario files
/// @returns {"seed", "wheels": [{name, change_percent, change_deg}]}; null where one of them is not
/// identified
nlohmann::ordered_json drift_cost_run(std::uint64_t seed, const std::filesystem::path& folder);

/// Means of the changes over all wheels and seeds, with their standard errors.
///
/// Met if a mean of at most 0.1 % and 0.05 degrees is certain: by two standard errors, which are taken from
/// the means of seeds, because the wheels of a seed share its road.
/// @returns {"runs", "seeds", "acceptance": [{"line", "value", "standard_error", "required", "met"}],
///   "accepted"}
nlohmann::ordered_json drift_cost_summary(const std::vector<nlohmann::ordered_json>& runs);

}  // namespace roadbalance
