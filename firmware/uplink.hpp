#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "common/bus/bus.hpp"
#include "firmware/node_link.hpp"

namespace roadbalance {

/// The bus as a node receives it: messages for the node go to `link`, which outlives it.
/// @throws std::runtime_error naming the URL
std::unique_ptr<Bus> open_node_bus(const std::string& url, std::int32_t node, NodeLink& link);

/// Process: ring and preview -> bus; acknowledgements and commands -> ring and acquire.  Has patience: it may
/// hang or die and sampling goes on until the ring is full.  A bus that fails is opened again, every second;
/// meanwhile nothing is due.
///
/// Ends when acquire has ended and the owner has everything durable; asked to stop, within a second.
///
/// @param open  gives the bus of open_node_bus()
/// @param warn  gets which recorder is of another version of the wire, and why there is no bus when that
///              lasts
/// @throws what `open` throws the first time
void uplink(std::stop_token stop, const std::function<std::unique_ptr<Bus>()>& open, NodeLink& link,
            const std::function<void(const std::string&)>& warn);

}  // namespace roadbalance
