#include "host/recording/formats/epoch_clock.hpp"

#include "common/bus/clock_messages.hpp"
#include "common/types/bounded_time.hpp"

namespace roadbalance {

EpochClock::EpochClock(const NodeEpoch& key, const std::optional<ClockFit>& first_fit, bool own_clocks)
    : key_(key), fits_(clock_fit_channel(key.first)), first_fit_(first_fit), own_clocks_(own_clocks) {}

void EpochClock::take(const LogEvent& event) {
  if (!own_clocks_ || (event.channel != fits_ && event.channel != kNoteChannel)) return;
  const auto fit = clocks_.take(event.channel, event.data);
  if (fit && NodeEpoch{fit->node, fit->epoch} == key_ && fit->is_known()) begun_ = true;
}

std::optional<std::int64_t> EpochClock::time_ns(std::int64_t node_ns) const {
  if (!own_clocks_) return node_ns;
  if (begun_) return clocks_.host_ns(key_, node_ns);
  return first_fit_ ? std::optional(host_instant_ns(*first_fit_, node_ns)) : std::nullopt;
}

}  // namespace roadbalance
