#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace roadbalance {

/// How near the demo comes to the truth.
/// @returns {"seed", "wheels": [{name, unbalance_g, ..., truth_g, truth_deg, truth_tyre_stiffness_n_m}]}
nlohmann::ordered_json demo_accuracy_run(std::uint64_t seed, double drive_seconds,
                                         const std::vector<double>& converter_ppm = {});

/// Summary of the runs, with the acceptance lines of the project:
///  - all wheels of at least 20 g within 10 % and 6 degrees in 18 of 20 seeds;
///  - median error of these wheels at most 3 % and 2 degrees, of tyre stiffness (all wheels) at most 3 %;
///  - the truth within two of the printed standard deviations for 85 to 99 % of all wheels, grams and degrees
///  apart.
/// A wheel that was not identified counts as outside everything.
/// @returns {..., "acceptance": [{"line", "value", "required", "met"}], "accepted"}
nlohmann::ordered_json demo_accuracy_summary(const std::vector<nlohmann::ordered_json>& runs);

}  // namespace roadbalance
