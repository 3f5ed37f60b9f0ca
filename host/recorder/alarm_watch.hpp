#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/control_messages.hpp"
#include "common/bus/recorder_status.hpp"
#include "common/bus/results.hpp"
#include "common/types/exchange.hpp"
#include "host/recorder/alarm_log.hpp"

namespace roadbalance {

/// Messages on the bus -> alarms: the same in the recorder, which puts them into the record, and in `rb
/// watch`.  A pure state machine.  Messages about other nodes than the watched ones are passed over.
///
/// An analyser that was never heard is not missed.  A clock is raised that is not heard or known worse than
/// to kWantedSync_s, after its first ten seconds.  A recorder that is started again raises anew what its
/// nodes have lost by then.
class AlarmWatch {
 public:
  /// After which a node that measures is missed, and an analyser that has spoken of it.
  static constexpr std::chrono::seconds kSilence{3};

  /// @param owner  of the nodes to watch: a recorder's incarnation; 0: every node
  explicit AlarmWatch(std::int64_t owner = 0) : owner_(owner) {}
  void set_owner(std::int64_t owner) { owner_ = owner; }

  void take(const Heartbeat& beat, WallTime now);
  void take(const Level& level, WallTime now);
  void take(const ClockFit& fit, WallTime now);
  void take(const Balance& wheel, WallTime now);
  void take(const RecorderStatus& status, WallTime now);
  /// A node, any recorder's: its messages cannot be read.
  void take_other_version(std::int32_t node, WallTime now);

  /// Looks who is silent.  To be called now and then, and before what follows.
  void turn(WallTime now);
  std::vector<AlarmNote> due(WallTime now) { return log_.due(now); }
  std::vector<AlarmNote> finish(WallTime now) { return log_.finish(now); }
  std::vector<ActiveAlarm> active() const { return log_.active(); }

 private:
  struct Node {
    std::int64_t epoch = 0;
    WallTime heard{};
    bool measures = false;
    bool wants_clock = false;   // a recorder asks it for its time
    WallTime clock_since{};     // since it needs one
    WallTime clock_heard{};     // last, and locked
    WallTime clock_answered{};  // though it may not be known
    std::int64_t clock_exchanges = 0;
    bool was_well_known = false;  // its clock, in this epoch
  };
  void miss_clock(std::int32_t number, const Node& node, WallTime now);
  void rise(const Alarm& alarm, std::int64_t epoch, std::int64_t count, const char* what, WallTime now);
  void take_channels(const Level& level, WallTime now);
  bool is_watched(std::int32_t node) const { return node_.contains(node); }

  std::int64_t owner_;
  AlarmLog log_;
  std::map<std::int32_t, Node> node_;
  bool analyser_spoke_ = false;
  WallTime analyser_heard_{};
  WallTime nobody_measured_{};  // last: then an analyser has nothing to report
  std::map<Alarm, std::pair<std::int64_t, std::int64_t>> counted_;  // epoch, count as it was heard last
};

}  // namespace roadbalance
