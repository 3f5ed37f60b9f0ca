#pragma once

#include <nlohmann/json.hpp>

#include "common/bus/results.hpp"

namespace roadbalance {

/// Springs, dampers and stabilisers at the wheel:
/// {"spring_n_m": [{"value", "sigma"} a wheel], "damper_n_s_m": the same, "stabiliser_n_m": [front, rear]};
/// null if they are not known, or one of them.
nlohmann::ordered_json suspension_json(const Identification& identification);

/// Speeds that an estimate rests on: [{"speed_m_s", "seconds"} a class].
nlohmann::ordered_json speeds_json(const Identification& identification);

}  // namespace roadbalance
