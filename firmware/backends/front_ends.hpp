#pragma once

#include <functional>
#include <string>

#include "common/frontend/registry.hpp"

namespace roadbalance {

/// Every device that a node can be given but the simulated one: replay, can, usb, gpio.
/// @param warn  hears what of a device will not do what somebody may expect
FrontEndRegistry real_front_ends(const std::function<void(const std::string&)>& warn);

}  // namespace roadbalance
