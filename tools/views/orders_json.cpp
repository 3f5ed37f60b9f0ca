#include "tools/views/orders_json.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "host/analysis/orders/angle_uncertainty.hpp"
#include "host/analysis/orders/order_peaks.hpp"
#include "tools/views/degrees.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostPeaks = 8;
constexpr double kNinetyFivePercent = 1.96;  // of a normal distribution

/// The highest line about an order: a rolling radius is known to a few per cent.
Json highest_about(const OrderSpectrum& spectrum, double order) {
  constexpr double kRadius = 0.04;
  const double width = std::max(kRadius * order, spectrum.step);
  Json highest;
  double most = 0.0;
  for (std::size_t k = 0; k < spectrum.amplitude.size(); ++k) {
    const double off = std::abs(static_cast<double>(k) * spectrum.step - order);
    if (spectrum.averages[k] == 0 || off > width || spectrum.amplitude[k] < most) continue;
    most = spectrum.amplitude[k];
    highest = most;
  }
  return highest;
}

/// Turns that run away from the wheel leave nothing but its spectrum.
Json magnitude_json(const OrderSpectrum& spectrum, double order) {
  return {{"amplitude", highest_about(spectrum, order)},
          {"amplitude_95", nullptr},
          {"phase_deg", nullptr},
          {"phase_95_deg", nullptr},
          {"blocks", spectrum.averages.empty() ? 0 : spectrum.averages.front()}};
}

/// null where the drive does not determine it.
Json vector_json(const MeanVector& vector, double order, const AngleUncertainty& uncertainty) {
  const auto confidence = vector.confidence();
  const bool phase = confidence && confidence->phase_rad && uncertainty.located;
  const auto reach_rad = [&] {
    return std::hypot(*confidence->phase_rad, kNinetyFivePercent * order * uncertainty.common_sigma_rad);
  };
  return {{"amplitude", vector.count() > 0 ? Json(std::abs(vector.mean())) : Json()},
          {"amplitude_95", confidence ? Json(confidence->amplitude) : Json()},
          {"phase_deg", phase ? Json(degrees(std::arg(vector.mean()))) : Json()},
          {"phase_95_deg", phase ? Json(degrees(reach_rad())) : Json()},
          {"blocks", vector.count()}};
}

Json spectrum_json(const OrderSpectrum& spectrum) {
  return {{"window", "flat_top"},
          {"step_order", spectrum.step},
          {"noise_bandwidth_order", spectrum.noise_bandwidth},
          {"amplitude", spectrum.amplitude},
          {"averages", spectrum.averages}};
}

/// The Vold-Kalman filter's result for the same order; null: it was not asked for, or not for this order.
Json crossing_json(const RecordOrders& found, const RotorOrders& rotor, const AngleUncertainty& uncertainty,
                   int c, double order) {
  for (const auto& crossing : found.crossing) {
    if (crossing->node().id != rotor.node().id) continue;
    const auto* of = crossing->find(rotor.rotor().name, rotor.channel()[static_cast<std::size_t>(c)], order);
    if (!of) continue;
    Json json = vector_json(of->all, order, uncertainty);
    json["bandwidth_hz"] = crossing->bandwidth_hz();
    json["seconds"] = of->used_s;
    json["together_s"] = of->together_s;
    json["by_speed"] = Json::array();
    const double class_m_s = crossing->class_hz(rotor.rotor().name) * rotor.way_m();
    for (const auto& [place, vector] : of->by_speed) {
      Json speed{{"from_m_s", place * class_m_s}, {"to_m_s", (place + 1) * class_m_s}};
      speed.update(vector_json(vector, order, uncertainty));
      json["by_speed"].push_back(speed);
    }
    return json;
  }
  return nullptr;
}

Json channel_json(const RecordOrders& found, const RotorOrders& rotor, const AngleUncertainty& uncertainty,
                  int c, bool waterfall) {
  const double way_m = rotor.way_m();
  const ChannelConfig& channel = rotor.node().channel[rotor.channel()[static_cast<std::size_t>(c)]];
  Json json{{"channel", channel.name}, {"unit", channel.role == ChannelRole::kRoad ? "m" : "m/s^2"}};
  const OrderSpectrum spectrum = rotor.waterfall().spectrum(c);
  for (std::size_t i = 0; i < rotor.order().size(); ++i) {
    if (uncertainty.by_speed) {
      Json magnitude{{"order", rotor.order()[i]}, {"phase_lasts", false}};
      magnitude.update(magnitude_json(spectrum, rotor.order()[i]));
      magnitude["by_speed"] = Json::array();
      json["orders"].push_back(magnitude);
      continue;
    }
    const OrderVectors::Result result = rotor.vectors().result(c, i);
    Json order{{"order", rotor.order()[i]}, {"phase_lasts", rotor.vectors().has_phase(i)}};
    order.update(vector_json(result.all, rotor.order()[i], uncertainty));
    order["by_speed"] = Json::array();
    for (const auto& one : result.by_speed) {
      Json speed{{"from_m_s", one.from_hz * way_m}, {"to_m_s", one.to_hz * way_m}};
      speed.update(vector_json(one.vector, rotor.order()[i], uncertainty));
      order["by_speed"].push_back(speed);
    }
    if (!found.crossing.empty())
      order["vold_kalman"] = crossing_json(found, rotor, uncertainty, c, rotor.order()[i]);
    json["orders"].push_back(order);
  }
  json["peaks"] = Json::array();
  for (const OrderPeak& peak : find_peaks(spectrum, kMostPeaks))
    json["peaks"].push_back({{"order", peak.order}, {"amplitude", peak.amplitude}});
  json["spectrum"] = spectrum_json(spectrum);
  if (!waterfall) return json;
  json["waterfall"] = Json::array();
  for (const auto& row : rotor.waterfall().rows(c)) {
    Json speed{{"from_m_s", row.from_hz * way_m}, {"to_m_s", row.to_hz * way_m}};
    speed.update(spectrum_json(row.spectrum));
    json["waterfall"].push_back(speed);
  }
  return json;
}

std::string text(const char* format, double value) {
  char buffer[200];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

}  // namespace

nlohmann::ordered_json rotor_json(const RecordOrders& found, const RotorOrders& rotor, bool waterfall) {
  const RotorOrders::Seconds seconds = rotor.seconds();
  const AngleUncertainty uncertainty = angle_uncertainty(found, rotor.rotor());
  Json json{
      {"wheel", rotor.rotor().name},
      {"node", rotor.node().name},
      {"ratio", rotor.rotor().ratio},
      {"seconds", seconds.recorded},
      {"no_angle_s", seconds.no_angle},
      {"uncertain_angle_s", seconds.uncertain},
      {"too_slow_s", seconds.slow},
      {"gaps", rotor.gaps()},
      {"blocks_from_s", rotor.stretch() ? Json(rotor.stretch()->from_s) : Json()},
      {"blocks_to_s", rotor.stretch() ? Json(rotor.stretch()->to_s) : Json()},
      {"angle_located", uncertainty.located},
      {"angle_sigma_deg",
       uncertainty.counted && uncertainty.located ? Json(degrees(uncertainty.sigma_rad)) : Json()},
      {"angle_common_sigma_deg",
       uncertainty.counted && uncertainty.located ? Json(degrees(uncertainty.common_sigma_rad)) : Json()},
      {"remark", remark_on(found, rotor)}};
  for (int c = 0; c < std::ssize(rotor.channel()); ++c)
    json["channels"].push_back(channel_json(found, rotor, uncertainty, c, waterfall));
  return json;
}

std::string remark_on(const RecordOrders& found, const RotorOrders& rotor) {
  if (std::string refusal = rotor.refusal(); !refusal.empty()) return refusal;
  const Rotor& turns = rotor.rotor();
  const AngleUncertainty uncertainty = angle_uncertainty(found, turns);
  if (uncertainty.by_speed)
    return "the bus tells its speed only: orders to a few per cent and their magnitudes, from the spectrum, "
           "but no "
           "angle, and no place for a weight";
  if (!uncertainty.contradiction.empty())
    return uncertainty.contradiction + " Until then magnitudes, but no angle, and no place for a weight";
  if (!uncertainty.located)
    return "no zero mark says where it stands: magnitudes of what turns with it, but no angle, and no place "
           "for a "
           "weight";
  if (turns.known_share == 0.0)
    return text(
        "ratio %.9g times the mean of its wheels is no simple fraction: the phase is counted from "
        "where the longest uninterrupted run began, and cannot be compared with another drive's",
        turns.ratio);
  if (turns.known_share < 1.0)
    return text("its angle is known modulo %.6g degrees only: phases of other orders than multiples of ",
                360.0 * turns.known_share) +
           text(
               "%.0f are counted from where the longest uninterrupted run began, and cannot be compared with "
               "another "
               "drive's",
               1.0 / turns.known_share);
  const bool on_the_bus = std::ranges::any_of(turns.wheel, [&](int wheel) {
    return !found.vehicle.wheel[static_cast<std::size_t>(wheel)].encoder.counter.empty();
  });
  if (uncertainty.counted)
    return text(on_the_bus ? "angle from a counter on the bus: an instant is known to %.2f degrees"
                           : "angle from the recorded pulses: an instant is known to %.2f degrees",
                degrees(uncertainty.sigma_rad)) +
           text(", the mean to %.2f degrees (sigma)", degrees(uncertainty.common_sigma_rad));
  return "";
}

}  // namespace roadbalance
