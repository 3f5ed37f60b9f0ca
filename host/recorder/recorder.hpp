#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/bus/absence.hpp"
#include "common/bus/notes.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/record/record_writer.hpp"
#include "common/types/clocks.hpp"
#include "host/recorder/epoch_scope.hpp"
#include "host/recorder/store_options.hpp"

namespace roadbalance {

/// One node epoch, as received and recorded.
struct NodeReport {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t samples_sent = 0;      ///< scans the node took between start and stop, by its own count
  std::int64_t samples_recorded = 0;  ///< scans in recorded blocks
  std::int64_t gaps = 0;              ///< declared, by the node or here
  std::int64_t repaired = 0;          ///< blocks the node had to send again
  std::int64_t blocks = 0;            ///< recorded, gaps included
  bool ended = false;                 ///< the end of the epoch is recorded, or its crash
  bool crashed = false;               ///< its crash is
  std::int64_t first_scan_block =
      0;  ///< sequence of a block with samples, the first recorded in this run; 0: none
  bool has_durable_samples = false;  ///< some of its samples are on the disk
  bool started = false;              ///< in this run: it measures or has measured, or may have begun to
  bool holds_blocks = false;         ///< in this run: by its last heartbeat
  bool ended_early = false;          ///< of a rest that is fetched: not by the stop of its recording
  double overload_s = 0;             ///< in this run: in blocks with a channel that left its range
  std::uint32_t blocks_crc32c = 0;   ///< in its end
  /// Whether its end sums up exactly the blocks that are recorded; nothing: there is no end, or no sum.
  std::optional<bool> sums_agree{};
};

/// Something to be put into the record now.
struct NoteToRecord {
  NoteKind kind = NoteKind::kMark;
  std::int64_t a = 0;
  std::int64_t b = 0;
  std::string text{};
  WallTime at{};  ///< it happened
};

/// A node that a recording is to have.
struct ExpectedNode {
  std::int32_t number = 0;
  std::string name{};       ///< empty: not known
  bool is_missing = false;  ///< it is known not to be there at the start
};

struct RecorderReport {
  std::vector<NodeReport> node;  ///< every epoch opened in this run, by node and then in order of time
  /// Those that the folder held before and that were not heard in this run.
  std::vector<NodeReport> earlier{};
  /// Datagrams that are no block of an epoch being recorded, repeats included.
  std::int64_t blocks_refused = 0;
  /// Heartbeats of a second epoch while the first one lived: two nodes with one number, or late datagrams.
  std::int64_t rival_heartbeats = 0;
  /// Nodes that obey another recorder, and are not recorded here.
  std::vector<std::int32_t> foreign{};
  /// Acknowledgements and commands that this computer would not send.
  std::int64_t unsent = 0;
  std::int64_t incarnation = 0;  ///< of the recorder, the last one if it was raised
  std::int32_t marks = 0;        ///< set, and on the disk
  /// In this run: of nodes that should have measured, by node.
  std::vector<Absence> absence{};
};

inline constexpr const char* kStoppedBySignal =
    "a signal to rb-recorder: its service, a person or a closed terminal";

struct RecorderOptions {
  std::string url;
  std::filesystem::path folder;
  bool continues = false;           ///< as in StoreOptions
  bool start = true;                ///< start each node that is claimed
  std::vector<std::int32_t> nodes;  ///< claim only these; empty: every node heard
  std::vector<Heartbeat> heard{};   ///< the last of each node that is there, so far as they are known
  /// End when each of `nodes` has ended and all of it is on the disk.
  bool end_with_nodes = false;
  /// Missed when they do not come or do not stay; beside them every node that came.
  std::vector<ExpectedNode> expected{};
  std::vector<Absence> absent_before{};  ///< in earlier runs of this recording; to_end: still so
  std::uint64_t segment_bytes = std::uint64_t{64} << 20;
  std::chrono::milliseconds commit_period{200};
  std::filesystem::path fallback;         ///< where recording goes on when the folder fails; empty: nowhere
  std::int64_t keep_bytes = 0;            ///< retention: delete the oldest finished segments beyond; 0: never
  std::int64_t reserve_bytes = 16 << 20;  ///< of the disk, not for measuring
  EpochScope scope{};
  bool first_at_once = false;          ///< as in StoreOptions
  bool keeps_awake = false;            ///< the computer: SleepInhibitor; what is refused is a warning
  std::int64_t first_incarnation = 0;  ///< no lower, whatever the wall clock is
  bool sends_state = true;  ///< false: another recorder of this program sends what the bus and on_alive get
  std::string power;  ///< the supply to watch: see open_power_line; empty: none.  A line that cannot be read
                      ///< ends a new recording before it begins; in one that is continued, or later, it is a
                      ///< warning, a note and an alarm
  /// After a stop request: how long to wait without any news for the nodes' last blocks.
  std::chrono::milliseconds patience{10'000};
  /// Requested: end at once as if killed, but with all that has been received on the disk: nodes are not
  /// stopped and no end is waited for.  Asked before the stop request.
  std::stop_token leave{};
  /// Called about five times a second from a thread of the recorder.
  std::function<void(const RecorderReport&)> on_progress;
  /// Called about twice a second while both processes turn: proof of life.
  std::function<void(const RecorderStatus&)> on_alive;
  /// Fills in the caller's part of the status that goes to the bus: who records, name, duration.
  std::function<void(RecorderStatus&)> complete;
  /// Called from the writer's thread some times a second: what is to be noted in the record now.
  std::function<std::vector<NoteToRecord>()> notes;
  /// Called once a stop is requested: by whom, for the record; not given: kStoppedBySignal.
  std::function<std::string()> stopped_by;
  /// Called with a sentence for people when the disk, the supply or the owner of a node changes; from either
  /// thread.
  std::function<void(const std::string&)> on_warning;
  /// Called at the start if a kill had torn the last segment: what was cut off, and where it is kept.
  std::function<void(const RecordWriter::CutTail&)> on_cut_tail;

  StoreOptions store() const;
};

/// Memory for a disk that is slow is reserved before it is: for the blocks of so many nodes.
void reserve_heap_for(std::size_t nodes);

/// Refuses options that stay wrong whatever is plugged in later; neither folders nor devices need be there.
/// @throws std::invalid_argument if `power` is no name of a line, or the fallback is the folder itself
void refuse_mistakes(const RecorderOptions& options);

/// Records every node that it hears until a stop is requested, then stops the nodes, waits for their last
/// blocks, and closes the record.  An existing folder is continued: what it holds is not recorded again.
///
/// Bus -> receive -> channel -> write -> disk; what is durable flows back and is acknowledged.  A disk that
/// fails or is full is a state that the nodes bridge, not an end.
/// @throws std::invalid_argument as refuse_mistakes(), or if the fallback holds another recording,
///         std::runtime_error, std::system_error naming bus, folder or file; also if something is not on the
///         disk in the end
RecorderReport run_recorder(std::stop_token stop, const RecorderOptions& options);

}  // namespace roadbalance
