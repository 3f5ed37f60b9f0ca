#pragma once

#include <stop_token>
#include <vector>

#include "common/process/channel.hpp"
#include "host/recorder/clock_asker.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recorder/recorder.hpp"
#include "host/recorder/recorder_link.hpp"
#include "host/recorder/write.hpp"

namespace roadbalance {

/// Process: bus -> deliveries, and acknowledgements, commands and the recorder's state back: a RecorderLink
/// on its bus.
///
/// On a stop request it stops the nodes, goes on until their ends are durable or nothing more comes, and
/// until they have heard so, releases them, and so closes `batches`.  When the writer is gone it ends too,
/// but leaves the nodes running: they keep what is not durable for the next recorder.
/// @param recovered  what the record holds
/// @param peers      hears of every heartbeat of a node that has a clock of its own
/// @throws std::runtime_error naming the bus
void receive(std::stop_token stop, const RecorderOptions& options, const Incarnation& incarnation,
             const RecordState& recovered, Out<WriteBatch> batches, In<WriterNews> news, Out<ClockPeer> peers,
             RecorderReport& report);

}  // namespace roadbalance
