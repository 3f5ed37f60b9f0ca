#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace roadbalance {

/// A zero mark among the counts of a ring.
struct PlacedMark {
  std::int64_t time_ns;
  double position;  ///< pulses since the run began
  double rate_hz;   ///< of the counter
};

/// Circular mean of where marks lie in a turn of so many pulses.
double mean_place(std::span<const PlacedMark> marks, double pulses);

/// Root mean square of their distances from a place, pulses; 0 without marks.
double scatter_about(std::span<const PlacedMark> marks, double place, double pulses);

/// The place within `width` of which most marks lie: a mean would follow the false ones.
double densest_place(std::span<const PlacedMark> marks, double pulses, double width);

/// The place moved between two marks.
struct MovedPlace {
  std::int64_t before_ns;  ///< the last at the place before
  std::int64_t behind_ns;  ///< the first at the place behind
};
/// Where in order of time three quarters of 16 marks lie within `width` of one place, and of 16 marks soon
/// after within `width` of another that is further away than that.  The first such place; nothing: no such.
std::optional<MovedPlace> first_move(std::span<const PlacedMark> marks, double pulses, double width);

}  // namespace roadbalance
