#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/link/epoch_receiver.hpp"
#include "common/process/channel.hpp"
#include "common/record/record.hpp"
#include "host/recorder/recover.hpp"

namespace roadbalance {

/// Everything of a node epoch through `sequence` is on the disk.
struct DurableMark {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t sequence = 0;
};

struct WriteOptions {
  std::filesystem::path folder;
  std::chrono::milliseconds commit_period{200};
};

/// Process: deliveries -> disk.  Appends in the order given, commits as a group, and only then says durable.
///
/// A commit is due after `commit_period`, after so many blocks that waiting would only fill buffers, and
/// after the end of an epoch.  Ends, with all on the disk and the record closed, when `deliveries` closes.
/// @throws std::system_error if the disk fails: what was not committed was not promised
void write_record(const WriteOptions& options, RecordWriter record,
                  std::map<NodeEpoch, std::vector<SealedBlock>> vehicle, In<std::vector<Delivery>> deliveries,
                  Out<std::vector<DurableMark>> durable);

}  // namespace roadbalance
