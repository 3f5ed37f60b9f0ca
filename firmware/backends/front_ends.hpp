#pragma once

#include <functional>
#include <string>

#include "common/frontend/registry.hpp"

namespace roadbalance {

/// Every device that a node can be given but the simulated one: replay, can, usb, gpio.
/// @param warn  hears what of a device will not do what somebody may expect
/// @param tell  hears how it went: of a replay by how much it was late
FrontEndRegistry real_front_ends(const std::function<void(const std::string&)>& warn,
                                 const std::function<void(const std::string&)>& tell = {});

}  // namespace roadbalance
