#pragma once

#include "common/bus/operation.hpp"
#include "common/process/channel.hpp"
#include "host/web/web_server.hpp"

namespace roadbalance {

/// "/request": a person asks the recorder for something, as parse_request() has it.  The answer comes on the
/// feed: the recorder may take seconds.
///
/// 202: asked; 400: no request, and why; 503: too much is asked at once.
/// @param requests  to who speaks to the bus; outlives what is returned
Post request_post(Out<Request>& requests);

}  // namespace roadbalance
