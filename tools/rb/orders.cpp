#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "host/orders/order_peaks.hpp"
#include "host/orders/orders_of_record.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/defects.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostPeaks = 8;

struct OrdersOptions {
  std::string folder;
  WantedOrders wanted;
  bool waterfall = false;
  bool json = false;
};

double degrees(double radians) {
  return radians * 180.0 / std::numbers::pi;
}

/// null where the drive does not say.
Json vector_json(const MeanVector& vector) {
  const auto confidence = vector.confidence();
  const bool phase = confidence && confidence->phase_rad;
  return {{"amplitude", vector.count() > 0 ? Json(std::abs(vector.mean())) : Json()},
          {"amplitude_95", confidence ? Json(confidence->amplitude) : Json()},
          {"phase_deg", phase ? Json(degrees(std::arg(vector.mean()))) : Json()},
          {"phase_95_deg", phase ? Json(degrees(*confidence->phase_rad)) : Json()},
          {"blocks", vector.count()}};
}

Json spectrum_json(const OrderSpectrum& spectrum) {
  return {{"window", "flat_top"},
          {"step_order", spectrum.step},
          {"noise_bandwidth_order", spectrum.noise_bandwidth},
          {"amplitude", spectrum.amplitude},
          {"averages", spectrum.averages}};
}

Json channel_json(const WheelOrders& wheel, int c, bool waterfall) {
  const double way_m = 2.0 * std::numbers::pi * wheel.rolling_radius_m();
  const ChannelConfig& channel = wheel.node().channel[wheel.channel()[static_cast<std::size_t>(c)]];
  Json json{{"channel", channel.name}, {"unit", channel.role == ChannelRole::kRoad ? "m" : "m/s^2"}};
  for (std::size_t i = 0; i < wheel.order().size(); ++i) {
    const OrderVectors::Result result = wheel.vectors().result(c, i);
    Json order{{"order", wheel.order()[i]}};
    order.update(vector_json(result.all));
    order["by_speed"] = Json::array();
    for (const auto& one : result.by_speed) {
      Json speed{{"from_m_s", one.from_hz * way_m}, {"to_m_s", one.to_hz * way_m}};
      speed.update(vector_json(one.vector));
      order["by_speed"].push_back(speed);
    }
    json["orders"].push_back(order);
  }
  const OrderSpectrum spectrum = wheel.waterfall().spectrum(c);
  json["peaks"] = Json::array();
  for (const OrderPeak& peak : find_peaks(spectrum, kMostPeaks))
    json["peaks"].push_back({{"order", peak.order}, {"amplitude", peak.amplitude}});
  json["spectrum"] = spectrum_json(spectrum);
  if (!waterfall) return json;
  json["waterfall"] = Json::array();
  for (const auto& row : wheel.waterfall().rows(c)) {
    Json speed{{"from_m_s", row.from_hz * way_m}, {"to_m_s", row.to_hz * way_m}};
    speed.update(spectrum_json(row.spectrum));
    json["waterfall"].push_back(speed);
  }
  return json;
}

Json wheel_json(const WheelOrders& wheel, bool waterfall) {
  const WheelOrders::Seconds seconds = wheel.seconds();
  Json json{{"wheel", wheel.wheel().name},
            {"node", wheel.node().name},
            {"seconds", seconds.recorded},
            {"no_angle_s", seconds.no_angle},
            {"uncertain_angle_s", seconds.uncertain},
            {"too_slow_s", seconds.slow},
            {"gaps", wheel.gaps()}};
  for (int c = 0; c < std::ssize(wheel.channel()); ++c)
    json["channels"].push_back(channel_json(wheel, c, waterfall));
  return json;
}

std::string with_confidence(const Json& value, const Json& reach, const char* figure,
                            const std::string& unit) {
  const auto text = [&](double number) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, figure, number);
    return std::string(buffer);
  };
  return text(value.get<double>()) + (reach.is_null() ? "" : " ± " + text(reach.get<double>())) + " " + unit;
}

void print_vector(const Json& vector, const std::string& unit) {
  std::printf("%s   %s   %d blocks\n",
              vector["amplitude"].is_null()
                  ? "amplitude not known"
                  : with_confidence(vector["amplitude"], vector["amplitude_95"], "%.4f", unit).c_str(),
              vector["phase_deg"].is_null()
                  ? "phase not known"
                  : with_confidence(vector["phase_deg"], vector["phase_95_deg"], "%.2f", "deg").c_str(),
              vector["blocks"].get<int>());
}

void print_channel(const Json& channel, bool by_speed) {
  const auto name = channel["channel"].get<std::string>(), unit = channel["unit"].get<std::string>();
  for (const Json& order : channel["orders"]) {
    std::printf("  %-24s order %-6.4g ", name.c_str(), order["order"].get<double>());
    print_vector(order, unit);
    if (!by_speed) continue;
    for (const Json& speed : order["by_speed"]) {
      std::printf("  %18.1f .. %.1f m/s       ", speed["from_m_s"].get<double>(),
                  speed["to_m_s"].get<double>());
      print_vector(speed, unit);
    }
  }
  std::printf("  %-24s peaks", name.c_str());
  for (const Json& peak : channel["peaks"])
    std::printf("  %.2f: %.4f", peak["order"].get<double>(), peak["amplitude"].get<double>());
  std::printf(channel["peaks"].empty() ? "  none\n" : "\n");
}

void print_wheel(const Json& wheel, bool by_speed) {
  std::printf("%s, node %s: %.1f s, without angle %.1f s, angle uncertain %.1f s, too slow %.1f s, %d gaps\n",
              wheel["wheel"].get<std::string>().c_str(), wheel["node"].get<std::string>().c_str(),
              wheel["seconds"].get<double>(), wheel["no_angle_s"].get<double>(),
              wheel["uncertain_angle_s"].get<double>(), wheel["too_slow_s"].get<double>(),
              wheel["gaps"].get<int>());
  for (const Json& channel : wheel["channels"]) print_channel(channel, by_speed);
}

/// Whether any vector has a confidence.
bool anything_known(const Json& wheels) {
  for (const Json& wheel : wheels)
    for (const Json& channel : wheel["channels"])
      for (const Json& order : channel["orders"])
        if (!order["amplitude_95"].is_null()) return true;
  return false;
}

int orders(const OrdersOptions& options) {
  const RecordOrders found = orders_of_record(options.folder, options.wanted);
  warn_of_defects("orders", options.folder, found.defects);
  Json wheels = Json::array();
  for (const auto& wheel : found.wheel) wheels.push_back(wheel_json(*wheel, options.waterfall));
  if (options.json) {
    std::printf("%s\n", Json{{"wheels", wheels}}.dump().c_str());
  } else {
    std::printf("# peak amplitude, phase against the zero mark, blocks of %d turns; ± is 95 %%\n",
                WheelOrders::kVectorTurns);
    for (const Json& wheel : wheels) print_wheel(wheel, options.wanted.channel.has_value());
  }
  if (anything_known(wheels)) return kDone;
  std::fprintf(stderr,
               "rb orders: too few whole turns at a known angle: no confidence below %d blocks of %d turns\n",
               MeanVector::kLeastVectors, WheelOrders::kVectorTurns);
  return kAnswerIsNo;
}

}  // namespace

void add_orders(CLI::App& app, int& code) {
  auto options = std::make_shared<OrdersOptions>();
  CLI::App* command = app.add_subcommand(
      "orders", "Order vectors (amplitude, phase against the zero mark) and order spectra of a recording");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_option("--wheel", options->wanted.wheel,
                      "its angle only; default: every wheel with an encoder");
  command->add_option(
      "--channel", options->wanted.channel,
      "this channel only, by classes of speed, too; default: every acceleration of the node that reads "
      "the encoder");
  command->add_option("--order", options->wanted.order, "orders of the vectors")->capture_default_str();
  command->add_flag("--waterfall", options->waterfall,
                    "with --json: a spectrum for each class of speed, too");
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = orders(*options); });
}

}  // namespace roadbalance
