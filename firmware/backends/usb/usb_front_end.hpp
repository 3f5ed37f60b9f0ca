#pragma once

#include <memory>

#include "common/frontend/registry.hpp"

namespace roadbalance {

/// Opens usb:VENDOR:PRODUCT[:SERIAL[+SERIAL]], the front-end board, or two that share their start.
/// @throws ConfigError, UsbError
std::unique_ptr<FrontEnd> open_usb_front_end(const FrontEndRequest& request);

}  // namespace roadbalance
