#pragma once

#include <functional>
#include <string>

#include "common/frontend/registry.hpp"

namespace roadbalance {

/// Every device that a node can be given but the simulated one: replay, can, usb, gpio.
/// @param warn  gets a sentence for each thing of a device that will not do what may be expected of it
/// @param inform  gets a sentence on how it went: for a replay by how much it was late
FrontEndRegistry real_front_ends(const std::function<void(const std::string&)>& warn,
                                 const std::function<void(const std::string&)>& inform = {});

}  // namespace roadbalance
