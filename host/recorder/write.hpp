#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/process/channel.hpp"
#include "host/recorder/power/power_line.hpp"
#include "host/recorder/recording_store.hpp"
#include "host/recorder/write_batch.hpp"

namespace roadbalance {

/// From the writer to the link: at least five times a second while it turns.
struct WriterNews {
  std::vector<DurableMark> marks;
  bool wants_credit = true;
  RecorderStatus status;  ///< its disk side
};

struct WriteOptions {
  PowerLine* power = nullptr;                               ///< nullptr: the supply is not watched
  std::function<void(const std::string&)> on_warning = {};  ///< a sentence for people
  std::function<std::vector<NoteToRecord>()> notes = {};    ///< notes that are due
};

/// Process: deliveries and other events -> disk: a RecordingStore and its thread, which watches the supply
/// too.
///
/// Ends, with all on the disk and the record closed, when `batches` closes.
/// @throws std::runtime_error if something could not be put on the disk in the end: it was not promised
void write_record(RecordingStore& store, const WriteOptions& options, In<WriteBatch> batches,
                  In<RecordEvent> events, Out<WriterNews> news);

}  // namespace roadbalance
