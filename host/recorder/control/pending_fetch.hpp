#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/control_messages.hpp"
#include "common/record/disk.hpp"
#include "common/types/clocks.hpp"
#include "host/recorder/control/operate.hpp"
#include "host/recorder/control/pending_epochs.hpp"
#include "host/recorder/control/recordings_folder.hpp"
#include "host/recorder/control/session.hpp"
#include "host/recorder/control/session_controller.hpp"

namespace roadbalance {

/// Keeps a SessionController's list of pending epochs: adds those that were not known, removes those that are
/// fetched, that have no folder any more, or that another recorder has taken over; and leads PendingEpochs,
/// by the incarnations that stand in the recordings' folders.
class PendingFetch {
 public:
  using BeginSession = std::function<std::unique_ptr<Session>(RecorderOptions)>;

  /// @param options  and folder: live as long as this
  PendingFetch(const OperateOptions& options, Disk& disk, BeginSession begin, RecordingsFolder& folder,
               RecordingsFolder::Warn warn, WallTime now);

  void take(const Heartbeat& heartbeat, WallTime now) { pending_.take(heartbeat, now); }
  /// Begins a session or ends one, if there is something to fetch.
  /// @return  the epochs that one has fetched
  std::optional<RecorderReport> turn(SessionController& controller, WallTime now);
  /// As if killed.
  void leave() { pending_.leave(); }
  /// A recording did: the last heartbeats are from before.
  void recording_ended(WallTime now) { ended_at_ = now; }

  /// Those of recorders of these recordings, as far as their folders can be read.
  std::vector<IncarnationRange> former_incarnations(const std::vector<PastRecording>& past) const;

 private:
  std::unique_ptr<Session> begin_session(const std::string& recording, EpochScope scope) const;
  std::vector<std::int64_t> incarnations_of(const std::string& recording) const;
  bool has_had(const std::string& recording, std::int64_t incarnation) const;
  std::vector<PendingEpoch> without_folder(const std::vector<PendingEpoch>& pending);
  void add_unknown(SessionController& controller, WallTime now);
  void forget_without_folder(SessionController& controller);
  void leave_to_others(SessionController& controller, WallTime now);

  const OperateOptions& options_;
  Disk& disk_;
  const BeginSession begin_;
  RecordingsFolder& folder_;
  const RecordingsFolder::Warn warn_;
  PendingEpochs pending_;
  WallTime ended_at_;  // the last recording did, or this recorder began
};

}  // namespace roadbalance
