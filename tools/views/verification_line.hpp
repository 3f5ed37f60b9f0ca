#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/bus/verification.hpp"

namespace roadbalance {

/// The effect of weights on a wheel, for people: "before 35.0 g, now 2.1 g: 94 % less, ± 3 %; good; ...".
std::string verification_line(const WheelVerification& verification);

nlohmann::ordered_json wheel_verification_json(const WheelVerification& verification);

}  // namespace roadbalance
