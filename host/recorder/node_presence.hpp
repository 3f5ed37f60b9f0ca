#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/absence.hpp"
#include "common/bus/control_messages.hpp"
#include "common/bus/notes.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/record/record_state.hpp"
#include "common/types/clocks.hpp"
#include "host/recorder/recorder.hpp"

namespace roadbalance {

/// Follows which nodes measure from the begin of a recording to its stop, and misses those that do not: notes
/// for the record, absences for the report.  A pure state machine.
///
/// A node is missed that is expected and does not come, and one that came and ended or fell silent.  One
/// whose source is over, a simulated drive or a file, is not, nor one that obeys another recorder.
class NodePresence {
 public:
  /// After which a node is missed that does not come, or falls silent.
  static constexpr std::chrono::milliseconds kSilence{2500};
  /// A shutdown ends nodes and recorder by signals, a few turns of theirs apart.  A node that ended longer
  /// before has ended for itself: what it lacks then is worth telling, even if it was the same shutdown.
  static constexpr std::chrono::milliseconds kEndsTogether{300};

  enum class Stop {
    kAsked,     ///< by a request: the nodes are to go on until they are stopped
    kBySignal,  ///< which may have ended the nodes, too
  };

  struct Options {
    bool misses = true;  ///< false: nobody is
    bool nodes_end_it =
        false;  ///< the recording ends with its nodes: only a device that failed ends one early
    std::vector<ExpectedNode> expected{};
    std::vector<Absence> before{};  ///< of earlier runs of this recording; to_end: still so
    std::int64_t utc_us = 0;        ///< now
  };
  /// @param recovered  whose nodes are expected, too
  NodePresence(Options options, const RecordState& recovered);

  /// The heartbeat is of an epoch that is recorded here.
  void take(const Heartbeat& heartbeat, WallTime now);
  /// It obeys another recorder.
  void take_foreign(std::int32_t node, WallTime now);
  /// Nobody was heard meanwhile, for this computer was held.
  void was_held(WallTime::duration held);
  /// Looks who is silent.
  /// @param notes  get who is missed, and who is there again
  void turn(WallTime now, std::vector<NoteToRecord>& notes);
  /// The recording is to end: from here on nobody is missed for a silence.  Those that have ended are.
  void stop(WallTime now, Stop how = Stop::kAsked);
  /// Nothing more will be heard: who never came is missed, however short the recording was.  Not known
  /// before, for the first heartbeat of a node that measures may come behind an early stop.
  void finish(WallTime now);

  /// Who is missed now.
  std::vector<AbsentNode> absent() const;
  /// All so far, those that last at their length up to the stop or to now.
  std::vector<Absence> absences(WallTime now, std::int64_t utc_us) const;

 private:
  struct Node {
    bool came = false;
    bool is_foreign = false;  // until it came
    std::int64_t epoch = 0;   // that measures or did last; 0: one of `former`, of an earlier run
    bool is_over = false;     // that epoch: what is heard of it still was sent before
    WallTime heard{};
    std::int64_t next_epoch = 0;  // heard while it is not known whether that has ended; 0: none
    WallTime next_at{};
    AbsenceCause cause = AbsenceCause::kNone;
    WallTime since{};
    WallTime seen{};  // that it is so
    bool is_noted = false;
    bool was_over_before = false;        // in an earlier run, which may have noted it
    std::vector<std::int64_t> former{};  // epochs, the latest
  };
  struct Past {
    Absence absence;
    WallTime since{};
  };
  void begin(WallTime now);
  static void remember(Node& node, std::int64_t epoch);
  void lose(Node& node, AbsenceCause cause, WallTime since, WallTime now);
  void find(std::int32_t number, Node& node, bool other_epoch, WallTime now);
  void note_there(std::int32_t number, bool lacks, WallTime now);
  bool is_missed(const Node& node) const;
  bool has_ended_early(const Node& node, const Heartbeat& last, WallTime now) const;
  void note_missing(std::int32_t number, Node& node, AbsenceCause cause);
  std::string name_of(std::int32_t number) const;

  const Options options_;
  std::map<std::int32_t, Node> nodes_;
  std::vector<Past> past_;
  std::vector<NoteToRecord> notes_;
  std::optional<WallTime> began_, stopped_;
  Stop stop_ = Stop::kAsked;
};

}  // namespace roadbalance
