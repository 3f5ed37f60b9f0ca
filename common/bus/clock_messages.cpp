#include "common/bus/clock_messages.hpp"

#include <cmath>
#include <wire/clock_exchange_t.hpp>
#include <wire/clock_fit_t.hpp>

#include "common/bus/node_number.hpp"
#include "common/bus/wire_format.hpp"
#include "common/link/block.hpp"

namespace roadbalance {
namespace {

bool is_clock(std::int64_t ns) {
  return -kClockLimit_ns <= ns && ns <= kClockLimit_ns;
}
bool is_index(std::int64_t value) {
  return 0 <= value && value <= kIndexLimit;
}
// No oscillator is wrong by a tenth: a fit that says so is none.
constexpr double kMostDrift = 0.1;

bool in_bounds(const wire::clock_fit_t& m) {
  return is_node(m.node) && is_index(m.number) && 0 <= m.state &&
         m.state <= static_cast<std::int32_t>(ClockState::kHoldover) && is_clock(m.host_ns) &&
         is_clock(m.node_ns) && std::abs(m.drift) <= kMostDrift && m.uncertainty_s >= 0 &&
         m.round_trip_s >= 0 && m.residual_s >= 0 && is_index(m.exchanges) && is_index(m.unanswered) &&
         is_index(m.breaks);
}

}  // namespace

std::string clock_exchange_channel(int node) {
  return std::string(kClockChannels) + "EXCHANGE_" + std::to_string(node);
}
std::string clock_fit_channel(int node) {
  return kClockChannels + std::to_string(node);
}

std::vector<std::uint8_t> encode(const ClockExchange& e) {
  wire::clock_exchange_t m{};
  m.node = e.node;
  m.epoch = e.epoch;
  m.number = e.number;
  m.asked_ns = e.asked_ns;
  m.received_ns = e.received_ns;
  m.answered_ns = e.answered_ns;
  m.heard_ns = e.heard_ns;
  m.stamps = static_cast<std::int32_t>(e.kernel_stamps);
  return wire_format::encode_with_crc(m);
}

std::optional<ClockExchange> decode_clock_exchange(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::clock_exchange_t>(bytes);
  if (!m || !is_node(m->node) || !is_index(m->number) || !is_clock(m->asked_ns) ||
      !is_clock(m->received_ns) || !is_clock(m->answered_ns) || !is_clock(m->heard_ns) || m->stamps < 0 ||
      m->stamps > 15)
    return std::nullopt;
  return ClockExchange{.node = m->node,
                       .epoch = m->epoch,
                       .number = m->number,
                       .asked_ns = m->asked_ns,
                       .received_ns = m->received_ns,
                       .answered_ns = m->answered_ns,
                       .heard_ns = m->heard_ns,
                       .kernel_stamps = static_cast<std::uint32_t>(m->stamps)};
}

std::vector<std::uint8_t> encode(const ClockFit& f) {
  wire::clock_fit_t m{};
  m.node = f.node;
  m.epoch = f.epoch;
  m.number = f.number;
  m.state = static_cast<std::int32_t>(f.state);
  m.host_ns = f.host_ns;
  m.node_ns = f.node_ns;
  m.drift = f.drift;
  m.uncertainty_s = f.uncertainty_s;
  m.round_trip_s = f.round_trip_s;
  m.residual_s = f.residual_s;
  m.exchanges = f.exchanges;
  m.unanswered = f.unanswered;
  m.breaks = f.breaks;
  return wire_format::encode_with_crc(m);
}

std::optional<ClockFit> decode_clock_fit(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode_with_crc<wire::clock_fit_t>(bytes);
  if (!m || !in_bounds(*m)) return std::nullopt;
  return ClockFit{.node = m->node,
                  .epoch = m->epoch,
                  .number = m->number,
                  .state = static_cast<ClockState>(m->state),
                  .host_ns = m->host_ns,
                  .node_ns = m->node_ns,
                  .drift = m->drift,
                  .uncertainty_s = m->uncertainty_s,
                  .round_trip_s = m->round_trip_s,
                  .residual_s = m->residual_s,
                  .exchanges = m->exchanges,
                  .unanswered = m->unanswered,
                  .breaks = m->breaks};
}

}  // namespace roadbalance
