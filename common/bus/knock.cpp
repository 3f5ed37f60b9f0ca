#include "common/bus/knock.hpp"

#include <algorithm>
#include <wire/knock_t.hpp>

#include "common/bus/node_number.hpp"
#include "common/bus/wire_format.hpp"

namespace roadbalance {

std::vector<std::uint8_t> encode(const Knock& k) {
  wire::knock_t m{};
  m.node = k.node;
  m.time_ns = k.time_ns;
  m.number = k.number;
  m.channel = k.channel;
  std::ranges::copy(k.first_m_s2, m.first_m_s2);
  std::ranges::copy(k.peak_m_s2, m.peak_m_s2);
  return wire_format::encode(m);
}

std::optional<Knock> decode_knock(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::knock_t>(bytes);
  if (!m || !is_node(m->node) || m->channel < 0 || m->channel >= kAccelerations) return std::nullopt;
  Knock k{.node = m->node, .time_ns = m->time_ns, .number = m->number, .channel = m->channel};
  std::ranges::copy(m->first_m_s2, k.first_m_s2.begin());
  std::ranges::copy(m->peak_m_s2, k.peak_m_s2.begin());
  return k;
}

}  // namespace roadbalance
