#pragma once

#include <cstdint>
#include <optional>

#include "firmware/backends/socketcan/accelerometer_frame.hpp"

namespace roadbalance {

/// Frames of a CAN accelerometer module to scans: puts the parts of classic CAN together and counts what the
/// sequence numbers leave out.
///
/// The index goes on over a gap: by the sequence numbers, and where these wrapped or began anew by the
/// stamps.  The first scan of a module that began anew is after_absence.
///
/// Eight bits that began anew show only by the stamps: the module was silent for 10 ms at least, as one is
/// that starts, and numbers and stamps disagree by more than 20 conversions, or two where it counts from 0. A
/// busy machine's stamps disagree as much, but not behind a silence: a controller keeps its oldest frames.
class AccelerometerScans {
 public:
  static constexpr double kRateHz = 1'000.0;

  /// @param time  the frame's stamp
  /// @return the scan that the frame completes; times are those of its first frame, as it was received
  std::optional<Scan> add(const AccelerometerFrame& frame, NodeTime time, bool after_absence) noexcept;

  /// Conversions that are missing, from the first scan on; not those of a module that was not there.
  std::int64_t missing() const { return missing_; }
  /// Frames that repeat a conversion.
  std::int64_t repeated() const { return repeated_; }

 private:
  std::optional<Scan> finish(std::uint32_t sequence, std::int64_t modulus) noexcept;
  struct Step {
    std::int64_t conversions = 0;  ///< since the last scan; 0: it is the last again
    bool began_anew = false;
  };
  Step step_to(std::uint32_t sequence, std::int64_t modulus) const noexcept;

  Scan scan_;          ///< being put together
  int next_part_ = 0;  ///< of it
  std::uint32_t part_sequence_ = 0;
  bool after_absence_ = false;
  bool started_ = false;
  std::uint32_t last_sequence_ = 0;
  NodeTime last_time_{};
  std::int64_t next_index_ = 0;
  std::int64_t missing_ = 0;
  std::int64_t repeated_ = 0;
};

}  // namespace roadbalance
