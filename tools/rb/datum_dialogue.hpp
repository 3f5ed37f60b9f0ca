#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/clock/clocks.hpp"
#include "host/calibration/datum_readings.hpp"

namespace roadbalance {

/// Leads somebody through DatumReadings: a pure state machine of edges, lines typed and time.
///
/// An answer counts when no edge has come for kStill after it: edges travel up to half a second, and a wheel
/// that still turns is not where it was read.
class DatumDialogue {
 public:
  static constexpr std::chrono::milliseconds kStill{700};

  /// @param wanted  readings, 2 and more
  DatumDialogue(const WheelConfig& wheel, int wanted);

  /// What to say first.
  std::string greeting() const;
  /// Each returns what is to be said now; empty: nothing.
  [[nodiscard]] std::string take(const Edge& edge, WallTime now);
  [[nodiscard]] std::string answer(const std::string& line, WallTime now);
  [[nodiscard]] std::string tick(WallTime now);

  /// The wheel stands behind its mark and nobody has said yet where.
  bool awaits_answer(WallTime now) const {
    return readings_.can_read() && !answer_rad_ && now - still_since_ >= kStill;
  }
  /// All readings are there.
  bool done() const { return static_cast<int>(readings_.readings()) >= wanted_; }
  const DatumReadings& readings() const { return readings_; }
  /// Why the readings cannot be used, to be said; empty: they can.
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
