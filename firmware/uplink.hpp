#pragma once

#include <functional>
#include <stop_token>
#include <string>

#include "firmware/node_link.hpp"

namespace roadbalance {

/// Process: ring and preview -> bus; acknowledgements and commands -> ring and acquire.  Has patience: it may
/// hang or die and sampling goes on until the ring is full.
///
/// Ends when acquire has ended and the owner has everything durable; told to stop, within a second.
///
/// @param warn  hears which recorder is of another version of the wire
/// @throws std::runtime_error if the bus cannot be opened
void uplink(std::stop_token stop, const std::string& bus_url, std::int32_t node, NodeLink& link,
            const std::function<void(const std::string&)>& warn);

}  // namespace roadbalance
