#pragma once

#include <cstdint>
#include <string>

namespace roadbalance {

/// This machine's own IPv4 address on the way to an LCM bus, as a number: others on the bus reach it there.
/// 0 if the bus is not UDP multicast or there is no route to it.
std::uint32_t address_on_bus(const std::string& url);

}  // namespace roadbalance
