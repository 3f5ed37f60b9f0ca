#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/types/exchange.hpp"

namespace roadbalance {

/// The relation of one node epoch's clock to the host's, second by second, from all exchanges of a finished
/// recording: as ClockModel, but each line runs through the exchanges up to 16 s before and after its
/// instant. Breaks of the time base are where ClockModel finds them.  Empty if there are too few exchanges.
/// @param exchanges  in the order in which they were recorded
std::vector<ClockFit> refine(std::span<const ClockExchange> exchanges);

/// Picks from refined fits the one nearest to each instant; instants come in order, but for breaks.
class RefinedFits {
 public:
  explicit RefinedFits(std::vector<ClockFit> fits) : fits_(std::move(fits)) {}

  /// The fit for a node's instant, or nullptr if there is none at all.
  const ClockFit* at(std::int64_t node_time_ns);

 private:
  std::vector<ClockFit> fits_;
  std::size_t next_ = 0;
};

}  // namespace roadbalance
