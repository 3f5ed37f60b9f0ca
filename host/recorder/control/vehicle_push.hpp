#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "common/bus/control_messages.hpp"
#include "common/types/clocks.hpp"

namespace roadbalance {

/// Puts another vehicle.toml in force at all nodes or at none; a pure state machine.
///
/// The text goes in parts, then the command; both again until each node has answered.  If one refuses or does
/// not answer in time those that have taken it get the old text back.
class VehiclePush {
 public:
  static constexpr std::chrono::milliseconds kRepeat{300};
  static constexpr std::chrono::seconds kPatience{20};  ///< a device is opened anew

  /// @param nodes  that are to take it
  VehiclePush(std::string before, std::string after, const std::vector<std::int32_t>& nodes,
              std::int64_t incarnation, std::uint64_t seed, WallTime now);

  struct Due {
    std::vector<VehiclePart> part;
    std::vector<Command> command;
  };
  /// To be sent now.
  Due due(WallTime now);
  void take(const Reply& reply);
  /// All have taken it, and it is not to be after all: each gets the old text back.  Refused in the end.
  /// Nothing happens unless it is done.
  void undo(std::string why);

  enum class State { kUnderWay, kDone, kRefused, kSilent };
  /// Refused and silent: and all that had taken it have the old one again, or do not answer any more.
  State state() const { return state_; }
  /// Which node, and its answer; then each that may measure by the new text although it was to be undone.
  const std::string& why() const { return why_; }
  const std::string& text() const { return after_; }

 private:
  struct Node {
    std::int64_t request = 0;
    bool has_answered = false;
    bool has_taken = false;
    std::string waits_for{};  ///< why it has not, in its words
  };
  void undo(State outcome, std::string why);
  void end_undoing();
  std::int64_t new_request();
  const std::string& wanted() const { return undoes_ ? before_ : after_; }

  const std::string before_, after_;
  const std::int64_t incarnation_;
  std::mt19937_64 random_;
  std::map<std::int32_t, Node> nodes_;
  WallTime begun_;
  WallTime reported_at_{};
  bool was_reported_ = false;
  bool undoes_ = false;
  bool restarts_ = false;  // kPatience counts from the next due()
  State outcome_ = State::kDone;
  State state_ = State::kUnderWay;
  std::string why_;
};

}  // namespace roadbalance
