#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string_view>

#include "common/clock/exchange.hpp"
#include "common/record/recorded_clocks.hpp"

namespace roadbalance {

/// Which of the clocks' events in several folders are to stand in the one record made of them: each exchange
/// and each fit once.  Segments begin with fits of before, and a recorder that goes on in its fallback folder
/// writes again there what it is not sure of.
class SalvageClocks {
 public:
  /// The next event, in the order of the folders; true of those of other channels.
  bool is_new(std::string_view channel, std::span<const std::uint8_t> data);

 private:
  RecordedClocks fits_;
  std::map<NodeEpoch, ClockExchange> last_;
};

}  // namespace roadbalance
