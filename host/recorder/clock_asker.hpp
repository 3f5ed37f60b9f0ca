#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/clock/clock_model.hpp"
#include "common/clock/clock_socket.hpp"
#include "common/process/channel.hpp"
#include "common/types/block.hpp"
#include "host/recorder/held_events.hpp"

namespace roadbalance {

/// A node epoch with a clock of its own, as its heartbeats name it.
struct ClockPeer {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  UdpAddress address;  ///< address 0: nothing answers there
};

/// Asks every node heard for its time and keeps a ClockModel of each epoch; a pure state machine.
///
/// 16 questions at 50 Hz, then 8 a second.  An answer counts from the address that was asked and once.  It
/// waits 50 ms for its follow-up.  A question not answered in a second is given up; an epoch whose heartbeats
/// have ceased for 10 s is asked no more until they come again, as they do when a cable is plugged in: then
/// in a burst, and its drift is still known.  Memory: at most 2 kMostNodes epochs with 32 questions each; the
/// one silent for longest makes room.
class ClockAsker {
 public:
  /// A heartbeat of a node that has its own clock.
  void heard(const ClockPeer& peer, MachineTime now);

  struct Question {
    ClockDatagram datagram;
    UdpAddress to;
  };
  /// Questions to send now.
  std::vector<Question> due(MachineTime now);
  void sent(const Question& question, const Stamp& stamp);

  void take(const ClockDatagram& datagram, const UdpAddress& from, const Stamp& heard);

  /// This computer was suspended: its clock shows how long, but not to the microsecond.
  void host_slept();

  /// Exchanges that are complete, since the last call.
  std::vector<ClockExchange> exchanges(MachineTime now);
  /// Fits that are due: of a new epoch at once, to declare that it has a clock of its own; when it locks,
  /// after a break, and every second.
  std::vector<ClockFit> fits(MachineTime now);

 private:
  struct Asked {
    std::int64_t number;
    Stamp sent;
    std::optional<ClockDatagram> answer;
    Stamp heard{};
  };
  struct Clock {
    UdpAddress address;
    ClockModel model;
    MachineTime heard_at;
    MachineTime ask_at;
    std::int64_t asked = 0;       ///< questions so far
    std::int64_t burst_ends = 0;  ///< with this one
    std::deque<Asked> open;
    MachineTime fit_at;
    ClockState state = ClockState::kAcquire;
    std::int64_t breaks = 0;
  };
  static bool is_silent(const Clock& clock, MachineTime now);
  /// False if all of them are spoken to.
  bool forget_one(MachineTime now);
  void complete(Clock& clock, const Asked& asked, std::int32_t node, std::int64_t epoch);

  std::map<std::pair<std::int32_t, std::int64_t>, Clock> clocks_;
  std::vector<ClockExchange> complete_;
};

/// Process: heartbeats' clock addresses -> exchanges and fits for the record, and fits for the bus: a
/// ClockAsker on its socket.
///
/// Never waits for the writer: while `events` is full events are dropped, and the record declares how many; a
/// fit shows by its number that one before it is missing.  Ends when `peers` closes.
/// @throws std::runtime_error naming the bus, std::system_error if there is no UDP socket to be had
void ask_clocks(const std::string& bus_url, In<ClockPeer> peers, Out<RecordEvent> events);

}  // namespace roadbalance
