#pragma once

#include <string>

#include "common/process/channel.hpp"
#include "host/recorder/clock_asker.hpp"
#include "host/recorder/record_keeper.hpp"

namespace roadbalance {

/// Process: heartbeats' clock addresses -> exchanges and fits for the record, and fits for the bus: a
/// ClockAsker on its socket.
///
/// Never waits for the writer: while `events` is full what would be written is dropped, and the record says
/// how much; a fit says by its number that one before it is missing.  Ends when `peers` closes.
/// @throws std::runtime_error naming the bus, std::system_error if there is no UDP socket to be had
void ask_clocks(const std::string& bus_url, In<ClockPeer> peers, Out<RecordEvent> events);

}  // namespace roadbalance
