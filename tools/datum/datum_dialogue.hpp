#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/types/clocks.hpp"
#include "host/analysis/calibration/datum_readings.hpp"

namespace roadbalance {

/// Leads a person through DatumReadings: a pure state machine of edges, lines typed and time.
///
/// An answer counts when no edge has come for kStill after it: edges travel up to half a second, and a wheel
/// that still turns is not where it was read.
class DatumDialogue {
 public:
  static constexpr std::chrono::milliseconds kStill{700};

  /// @param wanted  readings, 2 and more
  DatumDialogue(const WheelConfig& wheel, int wanted);

  /// The first text for the person.
  std::string greeting() const;
  /// Each returns the next text for the person; empty: none.
  [[nodiscard]] std::string take(const Edge& edge, WallTime now);
  [[nodiscard]] std::string answer(const std::string& line, WallTime now);
  [[nodiscard]] std::string tick(WallTime now);

  /// The wheel stands behind its mark and nobody has answered yet where.
  bool awaits_answer(WallTime now) const {
    return readings_.can_read() && !answer_rad_ && now - still_since_ >= kStill;
  }
  /// All readings are there.
  bool done() const { return static_cast<int>(readings_.readings()) >= wanted_; }
  const DatumReadings& readings() const { return readings_; }
  /// Why the readings cannot be used, for the person; empty: they can.
  std::string objection() const { return readings_.objection(); }

 private:
  std::string where_to_turn() const;

  const std::string name_;
  const bool left_;
  const int wanted_;
  DatumReadings readings_;
  std::optional<double> answer_rad_;  ///< waits until the wheel has been still
  WallTime still_since_{};
};

}  // namespace roadbalance
