#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "common/bus/control_messages.hpp"
#include "common/link/sender.hpp"
#include "firmware/acquire.hpp"
#include "firmware/vehicle_change.hpp"

namespace roadbalance {

/// The node's answers to commands, as a pure state machine.  A request acts once, however often it comes, and
/// gets the same reply each time.  A start and a stop name their instant by the delay to it: of several the
/// one that was on its way for the shortest time has it, and that is the earliest.  A stop is answered when
/// the end is sealed, with the end's sequence; a refused claim with the highest incarnation accepted, above
/// which the next claim may be.
class Commands {
 public:
  Commands(std::int32_t node, std::int64_t epoch, const Backlog& backlog, Sender& sender, AcquireLink& link,
           VehicleChange& vehicle);

  void take(const Command& command, WallTime now);

  /// The next reply to send, if there is one.
  std::optional<Reply> next_reply();
  /// A stop is not answered yet.
  bool waiting() const { return stop_request_.has_value(); }

 private:
  void configure(const Command& command, WallTime now);
  void answer(const Command& command, CommandError result, std::int64_t sequence);
  CommandError act(const Command& command, WallTime now);
  void take_instant(const Command& command, WallTime now);
  bool ended() const;
  bool is_owner(const Command& command) const;

  const std::int32_t node_;
  const std::int64_t epoch_;
  const Backlog& backlog_;
  Sender& sender_;
  AcquireLink& link_;
  VehicleChange& vehicle_;
  std::optional<Command> stop_request_;
  std::deque<Reply> known_;  ///< latest replies, to repeat
  std::deque<Reply> to_send_;
};

}  // namespace roadbalance
