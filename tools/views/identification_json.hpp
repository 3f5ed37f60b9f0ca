#pragma once

#include <nlohmann/json.hpp>

#include "common/bus/results.hpp"

namespace roadbalance {

/// Springs, dampers and stabilisers at the wheel:
/// {"spring_n_m": [{"value", "sigma"} a wheel], "damper_n_s_m": the same, "stabiliser_n_m": [front, rear]};
/// null if they are not known, or one of them.
nlohmann::ordered_json suspension_json(const Identification& identification);

/// Basis of an estimate, and goodness of fit of one linear car:
/// {"condition": of the suspension's equations,
///  "misfit": [{"of": "body" or the wheel, "square": chi^2, "chance": of as much}],
///  "mass_share": [{"of": "all_wheels" or the wheel, "value", "sigma"}] by which share a mass seems to
///  differ, "speeds": [{"speed_m_s", "seconds"} a class]};
/// null what was not judged.
nlohmann::ordered_json fit_json(const Identification& identification);

}  // namespace roadbalance
