#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace roadbalance {

/// The uniform clock behind uneven stamps: sample `index` was taken at first_s + index * period_s.
struct SampleClock {
  struct Hole {
    double after_s;        ///< stamp of the last sample before it
    std::int64_t samples;  ///< missing, by the clock
  };
  double first_s = 0.0;
  double period_s = 0.0;
  std::vector<std::int64_t> index;  ///< of each sample; jumps over the holes
  std::vector<Hole> hole;
  double stamp_rms_s = 0.0;  ///< deviation of the stamps from the clock
  double stamp_max_s = 0.0;
};

/// Fits a line of time over sample index.  Stamps may be bunched as a serial port delivers them; samples are
/// missing only where the stamps jump by more than 1.5 s or 50 periods.
///
/// @param stamp_s     at least 3, never falling
/// @param nominal_hz  tells how long 50 periods are
/// @throws std::invalid_argument if the stamps do not determine a line
SampleClock fit_sample_clock(std::span<const double> stamp_s, double nominal_hz);

}  // namespace roadbalance
