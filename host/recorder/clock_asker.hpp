#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/clock/clock_model.hpp"
#include "common/clock/clock_socket.hpp"
#include "common/link/block.hpp"

namespace roadbalance {

/// A node epoch with a clock of its own, as its heartbeats name it.
struct ClockPeer {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  UdpAddress address;  ///< address 0: nobody answers there
};

/// Asks every node heard for its time and keeps a ClockModel of each epoch; a pure state machine.
///
/// 16 questions at 50 Hz, then 8 a second.  An answer counts from the address that was asked and once.  It
/// waits 50 ms for its follow-up.  A question not answered in a second is given up; an epoch whose heartbeats
/// have ceased for 10 s is forgotten.  Memory: at most 2 kMostNodes epochs with 32 questions each.
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

  /// Exchanges that are complete, since the last call.
  std::vector<ClockExchange> exchanges(MachineTime now);
  /// Fits that are due: of a new epoch at once, to say that it has a clock of its own; when it locks, after a
  /// break, and every second.
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
    std::int64_t asked = 0;  ///< questions so far
    std::deque<Asked> open;
    MachineTime fit_at;
    ClockState state = ClockState::kAcquire;
    std::int64_t breaks = 0;
  };
  void complete(Clock& clock, const Asked& asked, std::int32_t node, std::int64_t epoch);

  std::map<std::pair<std::int32_t, std::int64_t>, Clock> clocks_;
  std::vector<ClockExchange> complete_;
};

}  // namespace roadbalance
