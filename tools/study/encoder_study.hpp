#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "tools/study/encoder_rows.hpp"

namespace roadbalance {

/// Difference of an estimated wheel angle to the truth.
struct AngleErrors {
  struct Size {
    double rms_deg = 0.0, max_deg = 0.0;
  };
  Size all;
  /// The same without the mean error of the stamps of the zero marks.  The angle counts from there
  /// and nothing else locates the wheel: with marks that jitter by s no estimate from n turns is more
  /// certain than s / sqrt(n) (Cramer and Rao).
  Size but_for_marks;
  int blocks = 0, unknown = 0;  ///< of 10 ms; those without an angle are in no error
  double lag_ms = 0.0;          ///< longest that a block waited for edges
};

/// The angle as a node computes it while driving: block by block, from the edges up to where the encoder
/// reports that its angles are at their best.
AngleErrors live_errors(const EncoderRow& row, const std::vector<Edge>& edges);

/// The angle as it is computed again from recorded edges, over the drive but its first and last second.
AngleErrors offline_errors(const EncoderRow& row, const std::vector<Edge>& edges);

/// The row's errors, live and offline, and whether they are allowed:
///
///     {"case", "rms_deg", "max_deg", "offline_rms_deg", "offline_max_deg", "allowed_rms_deg",
///     "allowed_max_deg", "unknown_blocks", "lag_ms", "runs", "runs_met", "runs_met_but_for_marks",
///     "worst_run_rms_deg", "met"}
///
/// Each run has the seed after that of the one before; rms is over all of them, max and lag are the largest.
/// `met` asks it of every run.  A block without an angle is not allowed, nor one that waits longer than a
/// BlockPacker does.  `allowed_max_deg` is null where it has no limit.
nlohmann::ordered_json encoder_row_result(EncoderRow row, int runs = 1);

}  // namespace roadbalance
