#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "common/bus/operation.hpp"

namespace roadbalance {

/// Parses a page's request: {"asker": 1, "request": 2, "operation": "mark", "text": "bridge"}, with "node",
/// "channel" and "value": [..] where the operation has them.  Returns the request, or the fault of the text;
/// an unknown key is one.
std::variant<Request, std::string> parse_request(std::string_view body);

/// "start": the name on the page and the command line; empty: there is none.
std::string_view name_of(Operation operation);

}  // namespace roadbalance
