#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace roadbalance {

/// How a state machine speaks without holding a bus.  False: this computer would not send it.
using Publish = std::function<bool(const std::string& channel, std::span<const std::uint8_t> bytes)>;

}  // namespace roadbalance
