#include "tools/rb/salvage_clocks.hpp"

#include "common/bus/clock_messages.hpp"

namespace roadbalance {

bool SalvageClocks::is_new(std::string_view channel, std::span<const std::uint8_t> data) {
  if (fits_.take(channel, data)) return true;
  const auto exchange = decode_clock_exchange(data);
  if (!exchange) return !decode_clock_fit(data);
  const auto [last, is_first] = last_.try_emplace({exchange->node, exchange->epoch}, *exchange);
  if (is_first) return true;
  // The host's clock begins anew with the host, the node's may be set back by a break.
  if (exchange->heard_ns <= last->second.heard_ns && exchange->received_ns <= last->second.received_ns)
    return false;
  last->second = *exchange;
  return true;
}

}  // namespace roadbalance
