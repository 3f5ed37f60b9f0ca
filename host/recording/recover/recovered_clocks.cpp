#include "host/recording/recover/recovered_clocks.hpp"

#include "common/bus/clock_messages.hpp"

namespace roadbalance {

bool RecoveredClocks::is_new(std::string_view channel, std::span<const std::uint8_t> data) {
  if (!channel.starts_with(kClockChannels)) return true;
  if (const auto exchange = decode_clock_exchange(data))
    return exchanges_[{exchange->node, exchange->epoch}]
        .emplace(exchange->asked_ns, exchange->received_ns)
        .second;
  if (const auto fit = decode_clock_fit(data))
    return fits_[{fit->node, fit->epoch}].emplace(fit->host_ns, fit->node_ns).second;
  return true;
}

}  // namespace roadbalance
