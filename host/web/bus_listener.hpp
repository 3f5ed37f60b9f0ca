#pragma once

#include <functional>
#include <stop_token>
#include <string>

#include "common/bus/operation.hpp"
#include "common/process/channel.hpp"
#include "host/web/topics.hpp"

namespace roadbalance {

/// Process: bus -> what the page shows of it.  Says who on the bus is of another version of the wire.
///
/// A server that is behind costs messages, never the bus: each topic is said again, or is a result of which
/// only the newest counts.
/// @param requests  of pages, for the recorder
void listen_to_bus(std::stop_token stop, const std::string& url, Out<TopicMessage> messages,
                   In<Request> requests, const std::function<void(const std::string&)>& on_warning);

}  // namespace roadbalance
