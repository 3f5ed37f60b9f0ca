#include "common/bus/tap.hpp"

#include <wire/knock_t.hpp>

#include "common/bus/fields.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<Tap> {
  using Wire = wire::knock_t;
  static void list(auto& field, auto& k, auto& m) {
    field(k.node, m.node, is_node);
    field(k.time_ns, m.time_ns);
    field(k.number, m.number);
    field(k.channel, m.channel, below(kAccelerations));
    field(k.first_m_s2, m.first_m_s2);
    field(k.peak_m_s2, m.peak_m_s2);
  }
};

}  // namespace wire_fields

std::vector<std::uint8_t> encode(const Tap& tap) {
  return wire_fields::encode(tap);
}

std::optional<Tap> decode_tap(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<Tap>(bytes);
}

}  // namespace roadbalance
