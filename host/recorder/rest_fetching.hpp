#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/control.hpp"
#include "common/clock/clocks.hpp"
#include "host/recorder/desk_book.hpp"
#include "host/recorder/epoch_scope.hpp"
#include "host/recorder/session.hpp"

namespace roadbalance {

/// What nodes hold of a recording that has just ended.
std::vector<Rest> rests_of(const RecorderReport& report, const std::string& recording);

/// Fetches what nodes that were cut off at a stop still hold into the recording it belongs to, as soon as one
/// is heard again, whatever else is recorded meanwhile; a pure state machine.
///
/// A session of that recording claims the epoch, stops it, and is over when its end is on the disk.  If
/// another epoch of the node has been heard for ten seconds and that one has not, the node was started anew
/// and its rest is lost: the session declares so.  What fails or is cut off again is tried again.
class RestFetching {
 public:
  using Begin = std::function<std::unique_ptr<Session>(const std::string& recording, EpochScope scope)>;
  explicit RestFetching(Begin begin) : begin_(std::move(begin)) {}

  void take(const Heartbeat& heartbeat, WallTime now);

  /// What nodes hold of recordings that are over, and nobody knows of: a recorder was killed after it had
  /// started them, and until the end they were cut off.  Not to be asked right behind the end of a recording:
  /// heartbeats may be from before.
  std::vector<Rest> unknown(const std::vector<Over>& over, const std::vector<Rest>& rests,
                            WallTime now) const;

  /// A session is over.
  struct Outcome {
    std::string recording;
    std::vector<Rest> settled;  ///< nothing of these is to be fetched any more
    std::vector<Rest> lost;     ///< of them: with their nodes
    RecorderReport report;
    std::string error;
  };
  /// Begins a session or ends one.
  std::optional<Outcome> turn(const std::vector<Rest>& rests, WallTime now);

  /// The recording whose rest is being fetched; empty: none.
  const std::string& under_way() const { return recording_; }
  /// As if killed.
  void leave();

 private:
  struct Heard {
    WallTime first{}, last{};
    std::int64_t owner = 0;
    bool holds_samples = false;
    bool is_settled = false;
  };
  bool is_heard(const Rest& rest, WallTime now) const;
  bool is_lost(const Rest& rest, WallTime now) const;
  void begin_one(const std::vector<Rest>& rests, WallTime now);
  Outcome end(const RecorderReport& report, const std::string& error) const;

  const Begin begin_;
  std::map<NodeEpoch, Heard> heard_;          // within the last kLongSilence
  std::map<std::string, WallTime> tried_at_;  // [recording]
  std::string recording_;
  EpochScope scope_;
  std::unique_ptr<Session> session_;
};

}  // namespace roadbalance
