#pragma once

#include <array>
#include <nlohmann/json.hpp>

#include "common/bus/compensation.hpp"
#include "common/bus/results.hpp"

namespace roadbalance {

/// The steps of a plan, {"action", "mass_g", "angle_deg", "radius_m", "kind", "plane"} each, of one to move
/// "from_deg", "from_radius_m" and "from_plane" too.  "kind" is "clip" or "adhesive", a plane "inner" or
/// "outer", null where vehicle.toml does not give it.
nlohmann::ordered_json steps_json(const WeightPlan& plan);

/// The "compensation" of rb identify and rb watch: one object a wheel, what there is to do and what it
/// leaves. "advice" is "steps", "leave_uncertain" or "leave_small", null with everything else where nothing
/// is known; "incurable" null or why weights will not cure it.
nlohmann::ordered_json compensation_json(const std::array<Balance, kWheels>& balance,
                                         const std::array<Compensation, kWheels>& compensation);

}  // namespace roadbalance
