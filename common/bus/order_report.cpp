#include "common/bus/order_report.hpp"

#include <wire/orders_t.hpp>

#include "common/bus/node_number.hpp"
#include "common/bus/wire_format.hpp"
#include "common/config/vehicle_config.hpp"

namespace roadbalance {

std::vector<std::uint8_t> encode(const OrderReport& report) {
  wire::orders_t m{};
  m.wheel = report.wheel;
  m.node = report.node;
  m.time_ns = report.time_ns;
  m.seconds = report.seconds;
  m.no_angle_s = report.no_angle_s;
  for (std::size_t h = 0; h < OrderReport::kOrders; ++h)
    for (std::size_t c = 0; c < kAccelerations; ++c) {
      const OrderReport::Vector& vector = report.order[h][c];
      m.vector[h][c][0] = vector.value.real();
      m.vector[h][c][1] = vector.value.imag();
      m.amplitude_95[h][c] = vector.amplitude_95;
      m.phase_95_rad[h][c] = vector.phase_95_rad;
      m.blocks[h][c] = vector.blocks;
    }
  return wire_format::encode(m);
}

std::optional<OrderReport> decode_orders(std::span<const std::uint8_t> bytes) {
  const auto m = wire_format::decode<wire::orders_t>(bytes);
  if (!m || m->wheel < 0 || m->wheel >= kWheels || !is_node(m->node)) return std::nullopt;
  OrderReport report;
  report.wheel = m->wheel;
  report.node = m->node;
  report.time_ns = m->time_ns;
  report.seconds = m->seconds;
  report.no_angle_s = m->no_angle_s;
  for (std::size_t h = 0; h < OrderReport::kOrders; ++h)
    for (std::size_t c = 0; c < kAccelerations; ++c) {
      if (m->blocks[h][c] < 0) return std::nullopt;
      report.order[h][c] = {{m->vector[h][c][0], m->vector[h][c][1]},
                            m->amplitude_95[h][c],
                            m->phase_95_rad[h][c],
                            m->blocks[h][c]};
    }
  return report;
}

}  // namespace roadbalance
