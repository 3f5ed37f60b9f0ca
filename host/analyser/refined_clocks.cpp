#include "host/analyser/refined_clocks.hpp"

#include <vector>

#include "common/bus/clock_messages.hpp"
#include "common/record/record.hpp"

namespace roadbalance {

RefinedClocks::RefinedClocks(const std::filesystem::path& folder) {
  std::map<std::pair<std::int32_t, std::int64_t>, std::vector<ClockExchange>> exchanges;
  RecordReader reader(folder);
  reader.finish();
  while (const auto event = reader.next())
    if (const auto exchange = decode_clock_exchange(event->data))
      exchanges[{exchange->node, exchange->epoch}].push_back(*exchange);
  for (const auto& [key, of_epoch] : exchanges)
    if (auto fits = refine(of_epoch); !fits.empty())
      clocks_.emplace(key, Clock{RefinedFits(std::move(fits))});
}

std::optional<ClockFit> RefinedClocks::next(const BlockHeader& block) {
  const auto found = clocks_.find({block.node, block.epoch});
  if (found == clocks_.end()) return std::nullopt;
  Clock& clock = found->second;
  const ClockFit* const fit = clock.fits.at(block.time_ns);
  if (std::exchange(clock.used, fit) == fit) return std::nullopt;
  return *fit;
}

}  // namespace roadbalance
