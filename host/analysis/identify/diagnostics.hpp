#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/bus/results.hpp"

namespace roadbalance {

/// Sentences for the driver: what an estimate rests on, and what would help more.  None while nothing is
/// known.
std::vector<std::string> diagnostics(const std::array<Balance, kWheels>& balance);

}  // namespace roadbalance
