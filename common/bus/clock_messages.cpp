#include "common/bus/clock_messages.hpp"

#include <wire/clock_exchange_t.hpp>
#include <wire/clock_fit_t.hpp>

#include "common/bus/fields.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<ClockExchange> {
  using Wire = wire::clock_exchange_t;
  static void list(auto& field, auto& e, auto& m) {
    field(e.node, m.node, is_node);
    field(e.epoch, m.epoch);
    field(e.number, m.number, is_index);
    field(e.asked_ns, m.asked_ns, is_clock);
    field(e.received_ns, m.received_ns, is_clock);
    field(e.answered_ns, m.answered_ns, is_clock);
    field(e.heard_ns, m.heard_ns, is_clock);
    field(e.kernel_stamps, m.stamps, up_to(15));
  }
};

template <>
struct Fields<ClockFit> {
  using Wire = wire::clock_fit_t;
  // No oscillator is wrong by a tenth: a fit with such a drift is none.
  static constexpr double kMostDrift = 0.1;
  static void list(auto& field, auto& f, auto& m) {
    field(f.node, m.node, is_node);
    field(f.epoch, m.epoch);
    field(f.number, m.number, is_index);
    field(f.state, m.state, up_to(ClockState::kHoldover));
    field(f.host_ns, m.host_ns, is_clock);
    field(f.node_ns, m.node_ns, is_clock);
    field(f.drift, m.drift, within(-kMostDrift, kMostDrift));
    field(f.uncertainty_s, m.uncertainty_s, at_least(0.0));
    field(f.round_trip_s, m.round_trip_s, at_least(0.0));
    field(f.residual_s, m.residual_s, at_least(0.0));
    field(f.exchanges, m.exchanges, is_index);
    field(f.unanswered, m.unanswered, is_index);
    field(f.breaks, m.breaks, is_index);
  }
};

}  // namespace wire_fields

std::string clock_exchange_channel(int node) {
  std::string channel = kClockChannels;
  return channel.append("EXCHANGE_").append(std::to_string(node));
}
std::string clock_fit_channel(int node) {
  return kClockChannels + std::to_string(node);
}

std::vector<std::uint8_t> encode(const ClockExchange& exchange) {
  return wire_fields::encode(exchange);
}
std::vector<std::uint8_t> encode(const ClockFit& fit) {
  return wire_fields::encode(fit);
}
std::optional<ClockExchange> decode_clock_exchange(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<ClockExchange>(bytes);
}
std::optional<ClockFit> decode_clock_fit(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<ClockFit>(bytes);
}

}  // namespace roadbalance
