#pragma once

#include "common/bus/bus.hpp"
#include "host/web/feed.hpp"
#include "host/web/web_server.hpp"

namespace roadbalance {

/// "/view": a page says what it wants to see, a view_t as it goes to the bus; what the analyser answers goes
/// to that page alone.  Said again each second, as on the bus.
///
/// 400: no view_t of this version, or of nobody; 503: too many pages ask, or it could not be sent.
/// @param bus   to say it on, of the server's own process
/// @param feed  outlives what is returned, as does the bus
Post view_post(Bus& bus, Feed& feed);

}  // namespace roadbalance
