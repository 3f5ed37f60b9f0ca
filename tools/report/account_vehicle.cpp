#include <cmath>

#include "common/text/format.hpp"
#include "common/text/markup.hpp"
#include "tools/report/account_sections.hpp"
#include "tools/report/html_parts.hpp"
#include "tools/views/degrees.hpp"

namespace roadbalance {
namespace {

using Rows = std::vector<std::vector<std::string>>;

constexpr double kConverterCounts = 8'388'608.0;  // 2^23

std::string fitted_weights(const WheelConfig& wheel) {
  std::string text;
  for (const WheelWeight& weight : wheel.fitted)
    text += format("%s%g g at %.0f°", text.empty() ? "" : ", ", weight.mass_g, degrees(weight.angle_rad));
  return text.empty() ? "none" : text;
}

std::string encoder(const WheelConfig& wheel) {
  if (wheel.node.empty()) return "none";
  const bool counted = !wheel.encoder.counter.empty();
  return format("%s, line %d: %d pulses a turn%s", wheel.node.c_str(), wheel.line,
                wheel.encoder.pulses_per_turn, wheel.encoder.quadrature ? ", two tracks" : "") +
         (counted ? ", counted on the bus (" + wheel.encoder.counter + ")" : "");
}

std::string zero_mark(const WheelConfig& wheel) {
  if (wheel.node.empty() || !wheel.encoder.zero_mark) return "none";
  return format("%.2f° ± %.2f°", degrees(wheel.encoder.datum_rad), degrees(wheel.encoder.datum_sigma_rad));
}

std::string wheels(const VehicleConfig& vehicle) {
  Rows rows;
  for (const WheelConfig& wheel : vehicle.wheel)
    rows.push_back({words(wheel.name), format("%.1f ± %.1f", wheel.mass_kg, wheel.mass_sigma_kg),
                    wheel.rotating_mass_kg ? format("%.1f", *wheel.rotating_mass_kg) : "–",
                    format("%.0f", 1e3 * wheel.rolling_radius_m), format("%.0f", 1e3 * wheel.weight_radius_m),
                    encoder(wheel), zero_mark(wheel), fitted_weights(wheel)});
  return table({"wheel", "unsprung, kg", "turning, kg", "rolling radius, mm", "weights at, mm", "encoder",
                "zero mark", "weights on it"},
               rows);
}

std::string model(const VehicleConfig& vehicle) {
  const ModelConfig& of = vehicle.model;
  if (!of.description.empty())
    return element("p", markup_text("Its form is described in " + of.description + "."));
  std::string html = element(
      "p",
      markup_text(format("Body %.0f ± %.0f kg, roll inertia %.0f ± %.0f kg m², pitch inertia %.0f ± "
                         "%.0f kg m². Of each axle, where the search for them begins:",
                         of.body_mass_kg, of.body_mass_sigma_kg, of.roll_inertia_kg_m2,
                         of.roll_inertia_sigma_kg_m2, of.pitch_inertia_kg_m2, of.pitch_inertia_sigma_kg_m2)));
  Rows rows;
  for (std::size_t a = 0; a < kAxles; ++a) {
    const AxleConfig& axle = of.axle[a];
    rows.push_back({a == 0 ? "front" : "rear", format("%.3f", axle.x_m),
                    format("%.3f", 2.0 * axle.half_track_m), format("%.1f", 1e-3 * axle.spring_n_m),
                    format("%.0f", axle.damper_n_s_m), format("%.1f", 1e-3 * axle.stabiliser_n_m),
                    format("%.0f", 1e-3 * axle.tyre_n_m),
                    format("%.0f ± %.0f", axle.tyre_damper_n_s_m, axle.tyre_damper_sigma_n_s_m)});
  }
  return html + table({"axle", "before the centre of mass, m", "track, m", "spring, kN/m", "damper, N s/m",
                       "stabiliser, kN/m", "tyre, kN/m", "tyre damping, N s/m"},
                      rows);
}

std::string limits(const VehicleConfig& vehicle) {
  const BalanceLimits& of = vehicle.limits;
  std::string text = format(
      "Judged by: %g g as a shop leaves them, G %g of ISO 21940-11, at most %g g on a wheel, %g N of force "
      "that does not grow with speed; an unbalance is wanted to ± %g g.",
      of.shop_g, of.grade_mm_s, of.heaviest_g, of.force_n, of.sigma_g);
  for (const SeatConfig& seat : vehicle.seat)
    text += format(" Seat %s at %.2f, %.2f, %.2f m, weight %g.", seat.name.c_str(), seat.position_m.x(),
                   seat.position_m.y(), seat.position_m.z(), seat.weight);
  for (const RotorConfig& rotor : vehicle.rotor)
    text += format(" %s turns %g times a turn of its wheels.", rotor.name.c_str(), rotor.ratio);
  return element("p", markup_text(text));
}

std::string nodes(const VehicleConfig& vehicle) {
  Rows rows;
  for (const NodeConfig& node : vehicle.node) {
    std::string devices, buses;
    for (const std::string& uri : node.wiring.front_end) devices += (devices.empty() ? "" : ", ") + uri;
    for (const CanConfig& can : node.wiring.can) buses += (buses.empty() ? "" : ", ") + can.interface;
    rows.push_back({node.name, std::to_string(node.id), format("%.3f", node.rate_hz),
                    std::to_string(node.channel.size()), devices.empty() ? "–" : devices,
                    buses.empty() ? "–" : buses, std::to_string(node.wiring.signals())});
  }
  return table({"node", "number", "rate, Hz", "channels", "devices", "buses", "signals of them"}, rows);
}

const char* role(const ChannelConfig& channel) {
  switch (channel.role) {
    case ChannelRole::kAcceleration:
      return "acceleration";
    case ChannelRole::kRoad:
      return "road";
    case ChannelRole::kUnused:
      break;
  }
  return "unused";
}

/// "+z" where it is along an axis.
std::string direction(const Eigen::Vector3d& of) {
  constexpr const char* kAxes[]{"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(of[axis]) > 1.0 - 1e-9) return std::string(of[axis] > 0.0 ? "+" : "−") + kAxes[axis];
  return format("%.3f, %.3f, %.3f", of.x(), of.y(), of.z());
}

/// Only the figures of the file distinguish a calibrated channel from one with the converter's nominal scale.
const char* source(const ChannelConfig& channel) {
  const bool nominal =
      channel.offset_counts == 0.0 &&
      std::abs(channel.scale_m_s2_per_count * kConverterCounts / channel.range_m_s2 - 1.0) < 1e-9;
  return nominal ? "nominal" : "calibrated";
}

std::string channels(const NodeConfig& node) {
  Rows rows;
  for (const ChannelConfig& channel : node.channel) {
    const char* const beside = channel.role == ChannelRole::kAcceleration ? "" : role(channel);
    rows.push_back({channel.name, words(channel.mount) + (*beside == '\0' ? "" : std::string(", ") + beside),
                    format("%.3f", channel.position_m.x()), format("%.3f", channel.position_m.y()),
                    format("%.3f", channel.position_m.z()), direction(channel.direction),
                    format("%.4g", channel.range_m_s2), format("%.6g", 1e6 * channel.scale_m_s2_per_count),
                    format("%.6g", channel.offset_counts), format("%.2g", 100.0 * channel.gain_sigma),
                    format("%.4g", 1e6 * channel.delay_s), source(channel)});
  }
  return table({"channel", "on", "x, m", "y, m", "z, m", "positive", "range, m/s²", "µm/s² a count",
                "offset, counts", "gain ±, %", "delay, µs", "calibration"},
               rows);
}

}  // namespace

std::string account_vehicle(const DriveReport& report) {
  return element("h2", "Vehicle") + model(report.vehicle) + wheels(report.vehicle) + limits(report.vehicle);
}

std::string account_sensors(const DriveReport& report) {
  const VehicleConfig& vehicle = report.vehicle;
  std::string html =
      element("h2", "Sensors and calibration") + nodes(vehicle) +
      element("p", markup_text(format("Before conversion each acceleration passes an anti-aliasing filter of "
                                      "order %d that cuts off at %g Hz.",
                                      vehicle.filter.order, vehicle.filter.cutoff_hz)));
  for (const NodeConfig& node : vehicle.node)
    html += element("div", element("h3", markup_text("Node " + node.name)) + channels(node), "whole");
  return html +
         element(
             "p",
             "x forward, y left, z up, from the centre of mass of the body. Nominal: range over 2²³ counts, "
             "no offset; calibrated: as vehicle.toml had it when the drive was recorded. The record holds no "
             "date of a calibration; changes during the drive are among its notes.",
             "facts");
}

}  // namespace roadbalance
