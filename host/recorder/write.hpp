#pragma once

#include <vector>

#include "common/process/channel.hpp"
#include "host/recorder/record_keeper.hpp"

namespace roadbalance {

/// Process: deliveries -> disk: a RecordKeeper and its thread.
///
/// Ends, with all on the disk and the record closed, when `deliveries` closes.
/// @throws std::system_error if the disk fails: what was not committed was not promised
void write_record(RecordKeeper& keeper, In<std::vector<Delivery>> deliveries,
                  Out<std::vector<DurableMark>> durable);

}  // namespace roadbalance
