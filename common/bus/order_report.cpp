#include "common/bus/order_report.hpp"

#include <wire/orders_t.hpp>

#include "common/bus/fields.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {
namespace wire_fields {

template <>
struct Fields<OrderReport> {
  using Wire = wire::orders_t;
  static void list(auto& field, auto& report, auto& m) {
    field(report.wheel, m.wheel, below(kWheels));
    field(report.node, m.node, is_node);
    field(report.time_ns, m.time_ns);
    field(report.seconds, m.seconds);
    field(report.no_angle_s, m.no_angle_s);
    for (std::size_t h = 0; h < OrderReport::kOrders; ++h)
      for (std::size_t c = 0; c < kAccelerations; ++c) {
        auto& vector = report.order[h][c];
        field(vector.value, m.vector[h][c]);
        field(vector.amplitude_95, m.amplitude_95[h][c]);
        field(vector.phase_95_rad, m.phase_95_rad[h][c]);
        field(vector.blocks, m.blocks[h][c], at_least(0));
      }
  }
};

}  // namespace wire_fields

std::vector<std::uint8_t> encode(const OrderReport& report) {
  return wire_fields::encode(report);
}

std::optional<OrderReport> decode_orders(std::span<const std::uint8_t> bytes) {
  return wire_fields::decode<OrderReport>(bytes);
}

}  // namespace roadbalance
