#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "common/bus/operation.hpp"

namespace roadbalance {

/// What the page asks: {"asker": 1, "request": 2, "operation": "mark", "text": "bridge"}, with "node",
/// "channel" and "value": [..] where the operation has them.  The request, or what is wrong with the text: an
/// unknown key, too.
std::variant<Request, std::string> parse_request(std::string_view body);

/// "start": as page and command line call it; empty: there is none.
std::string_view name_of(Operation operation);

}  // namespace roadbalance
