#pragma once

#include <string>
#include <vector>

#include "common/multibody/description.hpp"

namespace roadbalance {

/// Names of the descriptions that come with the program: quarter_car, half_car, seven_dof.
std::vector<std::string> shipped_descriptions();

/// @throws ConfigError naming those there are
Description shipped_description(const std::string& name);

}  // namespace roadbalance
