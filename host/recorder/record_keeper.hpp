#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "common/bus/recorder_status.hpp"
#include "common/clock/clocks.hpp"
#include "common/link/epoch_receiver.hpp"
#include "common/record/disk.hpp"
#include "common/record/record.hpp"
#include "host/recorder/recorder_link.hpp"
#include "host/recorder/recover.hpp"

namespace roadbalance {

struct KeeperOptions {
  std::filesystem::path folder;
  std::uint64_t segment_bytes = std::uint64_t{64} << 20;
  std::chrono::milliseconds commit_period{200};
  std::uint64_t commit_bytes = std::uint64_t{4} << 20;  ///< a commit is due after so many, however soon
};

/// Deliveries -> disk: appends in the order given, commits as a group, and only then says durable.
/// A pure state machine around a Disk; time comes in with every call.
class RecordKeeper {
 public:
  /// Creates the folder or continues one: locks it, cuts a torn tail, takes what it holds.
  /// @throws std::system_error naming the file, std::runtime_error if another recorder writes to the folder
  RecordKeeper(Disk& disk, KeeperOptions options);

  /// What the folder held.
  const Recovered& recovered() const { return recovered_; }
  const std::optional<RecordWriter::CutTail>& cut_tail() const { return writer_.cut_tail(); }

  /// The host's clocks at this instant; entries are stamped with the pair given last.
  void set_clocks(std::int64_t utc_us, std::int64_t host_ns);

  void append(const Delivery& delivery, WallTime now);
  bool commit_is_due(WallTime now) const;
  /// Until a commit is due if nothing more comes.
  std::chrono::milliseconds time_left(WallTime now) const;
  /// What is durable now and was not before.
  std::vector<DurableMark> commit(WallTime now);
  /// Commits and closes the record.
  std::vector<DurableMark> close(WallTime now);

  RecorderState state() const { return RecorderState::kRecording; }
  bool wants_credit() const { return state() == RecorderState::kRecording; }
  /// Fills in what the disk side of the recorder knows.
  void fill(RecorderStatus& status) const;

 private:
  Disk& disk_;
  const KeeperOptions options_;
  RecordWriter writer_;
  Recovered recovered_;
  std::map<NodeEpoch, std::vector<SealedBlock>> vehicle_;
  std::map<NodeEpoch, std::int64_t> pending_;  // appended, not committed
  WallTime oldest_{};
  std::uint64_t uncommitted_bytes_ = 0;
  std::int64_t waiting_blocks_ = 0;
  std::int64_t bytes_recorded_ = 0;
  bool urgent_ = false;
  int listed_ = 0;  // last segment that the manifest lists as finished
  std::int64_t utc_us_ = 0;
  std::int64_t host_ns_ = 0;
};

}  // namespace roadbalance
