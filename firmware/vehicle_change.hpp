#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/control_messages.hpp"

namespace roadbalance {

/// The vehicle.toml a node measures by, and another one that the bus brings in numbered parts; outlives the
/// epochs, each of which has one text.  A pure state machine of bounded memory.
///
/// The command with the verb configure is answered when the change has been made or refused, by the epoch
/// after.
class VehicleChange {
 public:
  /// @param text  in force
  /// @param can_change  false: this node cannot open its devices anew
  VehicleChange(std::string text, bool can_change);

  std::uint32_t in_force() const { return crc32c_; }
  const std::string& text() const { return text_; }

  void take(const VehiclePart& part);

  struct Outcome {
    CommandError result = CommandError::kNone;
    std::string why{};
  };
  /// The outcome that is known at once; nothing: it is wanted from now on, and outcome() will follow.
  std::optional<Outcome> ask(const Command& command);
  /// The outcome of a request that was wanted earlier.
  std::optional<Outcome> outcome(std::int64_t request) const;

  /// The text that is wanted; nullptr: none.
  const std::string* wanted() const { return wanted_ ? &wanted_->text : nullptr; }
  /// The outcome of the request.
  void made();
  void refused(const std::string& why);

 private:
  struct Wanted {
    std::int64_t request = 0;
    std::string text;
  };
  struct AnsweredRequest {
    std::int64_t request = 0;
    Outcome outcome;
  };
  std::optional<std::string> assembled(std::uint32_t crc32c) const;
  void finish(Outcome outcome);

  std::string text_;
  std::uint32_t crc32c_;
  const bool can_change_;
  std::uint32_t arriving_ = 0;  // CRC of the text whose parts these are
  std::vector<std::string> part_;
  std::optional<Wanted> wanted_;
  std::deque<AnsweredRequest> answered_;  // the latest, to repeat their outcomes
};

}  // namespace roadbalance
