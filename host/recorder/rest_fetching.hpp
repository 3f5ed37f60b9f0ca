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
  /// Whether a recorder of this recording has had this incarnation.
  using IsOf = std::function<bool(const std::string& recording, std::int64_t incarnation)>;
  RestFetching(Begin begin, IsOf is_of) : begin_(std::move(begin)), is_of_(std::move(is_of)) {}

  void take(const Heartbeat& heartbeat, WallTime now);

  /// What nodes hold of recordings that are over, and nobody knows of: a recorder was killed after it had
  /// started them, and until the end they were cut off.  Not to be asked right behind the end of a recording:
  /// heartbeats may be from before.
  std::vector<Rest> unknown(const std::vector<Over>& over, const std::vector<Rest>& rests, WallTime now);

  /// Those whose nodes have obeyed another recorder for kPatience: it has taken them over.
  std::vector<Rest> taken_over(const std::vector<Rest>& rests, WallTime now);

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

  static constexpr std::chrono::seconds kPatience{3};  ///< a heartbeat may be late

 private:
  struct Heard {
    WallTime first{}, last{};
    std::int64_t owner = 0;
    WallTime owned_since{};  // by it
    bool holds_samples = false;
    bool is_settled = false;
  };
  struct Known {
    WallTime at{};
    bool is_of = false;
  };
  const Heard* heard_now(const Rest& rest, WallTime now) const;
  bool is_of(const std::string& recording, std::int64_t incarnation, WallTime now);
  bool is_free(const Rest& rest, WallTime now);
  bool is_taken_from_session(WallTime now);
  bool is_lost(const Rest& rest, WallTime now) const;
  void begin_one(const std::vector<Rest>& rests, WallTime now);
  Outcome end(const RecorderReport& report, const std::string& error) const;

  const Begin begin_;
  const IsOf is_of_;
  std::map<NodeEpoch, Heard> heard_;          // within the last kLongSilence
  std::map<std::string, WallTime> tried_at_;  // [recording]
  // What is_of_ said lately, for it reads a disk: [recording, incarnation].
  std::map<std::pair<std::string, std::int64_t>, Known> known_;
  std::string recording_;
  EpochScope scope_;
  std::unique_ptr<Session> session_;
};

}  // namespace roadbalance
