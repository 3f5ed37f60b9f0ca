#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/frontend/registry.hpp"

namespace roadbalance {

/// Opens usb:VENDOR:PRODUCT[:SERIAL[+SERIAL]], the front-end board, or two that share their start.
/// @param warn  gets what works but a person should know, and why a board that is gone cannot be opened; from
///              another thread, too
/// @throws ConfigError, UsbError
std::unique_ptr<FrontEnd> open_usb_front_end(const FrontEndRequest& request,
                                             std::function<void(const std::string&)> warn);

}  // namespace roadbalance
