#include "tools/views/order_lines.hpp"

#include <cmath>
#include <numbers>

#include "common/config/vehicle_config.hpp"
#include "common/text/format.hpp"
#include "tools/views/degrees.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

const char* wheel_name(const OrderReport& report) {
  return kWheelNames[static_cast<std::size_t>(report.wheel)];
}

std::string line(const OrderReport& report, std::size_t order, std::size_t channel) {
  const OrderReport::Vector& vector = report.order[order][channel];
  std::string all = format("%s, order %zu: node %d channel %zu  %.4f ± %.4f m/s²", wheel_name(report),
                           order + 1, report.node, channel + 1, std::abs(vector.value), vector.amplitude_95);
  if (!std::isnan(vector.phase_95_rad))
    all += format("  %.1f ± %.1f deg", degrees(std::arg(vector.value)), degrees(vector.phase_95_rad));
  return all + "  " + std::to_string(vector.blocks) + " blocks";
}

bool is_known(const OrderReport::Vector& vector) {
  return vector.blocks > 0 && !std::isnan(vector.amplitude_95);
}

Json known(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

}  // namespace

std::vector<std::string> strongest_order_lines(const OrderReports& reports, std::int32_t wheel) {
  std::vector<std::string> lines;
  for (std::size_t order = 0; order < OrderReport::kOrders; ++order) {
    const OrderReport* where = nullptr;
    std::size_t channel = 0;
    double most = 0.0;
    for (const auto& [key, report] : reports)
      for (std::size_t c = 0; key.first == wheel && c < kAccelerations; ++c) {
        const OrderReport::Vector& vector = report.order[order][c];
        if (!is_known(vector) || std::abs(vector.value) < most) continue;
        most = std::abs(vector.value);
        where = &report;
        channel = c;
      }
    if (where) lines.push_back(line(*where, order, channel));
  }
  return lines;
}

std::vector<std::string> order_lines(const OrderReport& report) {
  std::vector<std::string> lines;
  for (std::size_t order = 0; order < OrderReport::kOrders; ++order)
    for (std::size_t c = 0; c < kAccelerations; ++c)
      if (is_known(report.order[order][c])) lines.push_back(line(report, order, c));
  return lines;
}

nlohmann::ordered_json order_report_json(const OrderReport& report) {
  Json json{{"wheel", wheel_name(report)},
            {"node", report.node},
            {"seconds", report.seconds},
            {"no_angle_s", report.no_angle_s},
            {"orders", Json::array()}};
  for (std::size_t order = 0; order < OrderReport::kOrders; ++order)
    for (std::size_t c = 0; c < kAccelerations; ++c) {
      const OrderReport::Vector& vector = report.order[order][c];
      if (vector.blocks == 0) continue;
      const bool phase = !std::isnan(vector.phase_95_rad);
      json["orders"].push_back({{"order", order + 1},
                                {"channel", c + 1},
                                {"amplitude", std::abs(vector.value)},
                                {"amplitude_95", known(vector.amplitude_95)},
                                {"phase_deg", phase ? Json(degrees(std::arg(vector.value))) : Json(nullptr)},
                                {"phase_95_deg", known(degrees(vector.phase_95_rad))},
                                {"blocks", vector.blocks}});
    }
  return json;
}

}  // namespace roadbalance
