#pragma once

#include <array>
#include <cstdint>
#include <numbers>

#include "common/bus/bus.hpp"

namespace roadbalance {

inline constexpr std::int64_t kIncarnation = 1'763'741'000'000;
inline constexpr double kDegree = std::numbers::pi / 180.0;

struct Scene {
  bool known = true;      ///< the unbalances
  bool armed = false;     ///< a recording has ended, with a receipt; the next may begin
  bool verified = false;  ///< a drive before weights were fitted is known
  bool analysed = true;   ///< an analyser is there: levels and results
  bool trouble = false;   ///< disk full, samples lost, clock held over, overload, dead channel, faulty turns
  bool disk_is_away = false;
  bool device_is_gone = false;  ///< of node 2
};
/// What weights at 37 degrees make of 35 g at 217: nearly nothing; fitted at -37, 2 |sin 37| times as much;
/// at 217 twice as much; or not fitted.
inline constexpr std::array kAfter_g{2.0, 42.1, 70.0, 35.0}, kAfterDegrees{80.0, 270.0, 217.0, 217.0};

/// What a node is, the last knock, recordings, remarks and what weights have done.
void say_rest(Bus& bus, const Scene& scene);

}  // namespace roadbalance
