#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/control_messages.hpp"
#include "common/types/clocks.hpp"
#include "host/recorder/control/session.hpp"
#include "host/recorder/control/session_state.hpp"
#include "host/recorder/epoch_scope.hpp"

namespace roadbalance {

/// Epochs that nodes hold of a recording that has just ended.
std::vector<PendingEpoch> pending_of(const RecorderReport& report, const std::string& recording);

/// Fetches the blocks that nodes still hold which were cut off at a stop, into the recording to which they
/// belong, as soon as a node is heard again, whatever else is recorded meanwhile; a pure state machine.
///
/// A node whose cable is out at a stop measures on in its old epoch: all of that belongs to the recording
/// that was stopped, and the node joins the next one when it is on the disk.  A session of that recording
/// claims the epoch, stops it, and is over when its end is on the disk.  If another epoch of the node has
/// been heard for ten seconds and that one has not, the node was started anew and its rest is lost: the
/// session declares so.  A session that fails or is cut off again is tried again.
///
/// The same session ends the epoch of a node that never got its start, which else stayed out of the next
/// recording, and lets a node go whose end is on the disk without its having heard so.  The rest of a node
/// that another recorder has taken over is left to that one: a claim would win in a moment in which that
/// recorder is held, and stop a node that is being measured with.
class PendingEpochs {
 public:
  using Begin = std::function<std::unique_ptr<Session>(const std::string& recording, EpochScope scope)>;
  /// Whether a recorder of this recording has had this incarnation.
  using IsOf = std::function<bool(const std::string& recording, std::int64_t incarnation)>;
  PendingEpochs(Begin begin, IsOf is_of) : begin_(std::move(begin)), is_of_(std::move(is_of)) {}

  void take(const Heartbeat& heartbeat, WallTime now);

  /// Epochs of recordings that are over which are not known to be held: a recorder was killed after it had
  /// started them, and until the end they were cut off.  Their heartbeats bear the incarnation that they
  /// obeyed, for a node is released only when all that it holds is on the disk.  Not to be asked right behind
  /// the end of a recording: heartbeats may be from before.
  std::vector<PendingEpoch> unknown(const std::vector<PastRecording>& past,
                                    const std::vector<PendingEpoch>& pending, WallTime now);

  /// Those whose nodes have obeyed another recorder for kPatience: it has taken them over.
  std::vector<PendingEpoch> taken_over(const std::vector<PendingEpoch>& pending, WallTime now);

  /// A session is over.
  struct Outcome {
    std::string recording;
    std::vector<PendingEpoch> settled;  ///< nothing of these is to be fetched any more
    std::vector<PendingEpoch> lost;     ///< of them: with their nodes
    RecorderReport report;
    std::string error;
  };
  /// Begins a session or ends one.
  std::optional<Outcome> turn(const std::vector<PendingEpoch>& pending, WallTime now);

  /// The recording whose rest is being fetched; empty: none.
  const std::string& under_way() const { return recording_; }
  /// As if killed.
  void leave();

  static constexpr std::chrono::seconds kPatience{3};  ///< a heartbeat may be late

 private:
  struct Heard {
    WallTime first{}, last{};
    std::int64_t owner = 0;
    WallTime owned_since{};  // by it
    bool holds_samples = false;
    bool is_settled = false;
  };
  struct CachedResult {
    WallTime at{};
    bool is_of = false;
  };
  const Heard* heard_now(const PendingEpoch& epoch, WallTime now) const;
  bool is_of(const std::string& recording, std::int64_t incarnation, WallTime now);
  bool is_free(const PendingEpoch& epoch, WallTime now);
  bool is_taken_from_session(WallTime now);
  bool is_lost(const PendingEpoch& epoch, WallTime now) const;
  void begin_one(const std::vector<PendingEpoch>& pending, WallTime now);
  Outcome end(const RecorderReport& report, const std::string& error) const;

  const Begin begin_;
  const IsOf is_of_;
  std::map<NodeEpoch, Heard> heard_;          // within the last kLongSilence
  std::map<std::string, WallTime> tried_at_;  // [recording]
  // Latest results of is_of_, for it reads a disk: [recording, incarnation].
  std::map<std::pair<std::string, std::int64_t>, CachedResult> is_of_cache_;
  std::string recording_;
  EpochScope scope_;
  std::unique_ptr<Session> session_;
};

}  // namespace roadbalance
