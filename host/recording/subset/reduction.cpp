#include "host/recording/subset/reduction.hpp"

#include <algorithm>
#include <cmath>

namespace roadbalance {

int largest_reduction(const VehicleConfig& vehicle) {
  const double rate_hz = vehicle.node.front().rate_hz, least_hz = 2.0 * vehicle.filter.cutoff_hz;
  constexpr double kLargest = 1e6;  // a rate of 100 kHz and a cutoff of 0.1 Hz give 5e5
  int factor = static_cast<int>(std::min(rate_hz / least_hz, kLargest));
  while (factor > 1 && rate_hz / factor <= least_hz) --factor;
  return std::max(1, factor);
}

}  // namespace roadbalance
