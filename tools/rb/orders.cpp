#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/command_line/bus_url.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/analysis/orders/orders_of_record.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/reading_progress.hpp"
#include "tools/views/bus_view.hpp"
#include "tools/views/order_lines.hpp"
#include "tools/views/orders_json.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/recording_defects.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct OrdersOptions {
  std::string folder;
  WantedOrders wanted;
  bool waterfall = false;
  bool json = false;
  bool live = false;
  std::string url;
  double seconds = 0.0;  ///< of the live view; 0: until interrupted
};

std::string with_confidence(const Json& value, const Json& reach, const char* figure,
                            const std::string& unit) {
  const auto text = [&](double number) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, figure, number);
    return std::string(buffer);
  };
  return text(value.get<double>()) + (reach.is_null() ? "" : " ± " + text(reach.get<double>())) + " " + unit;
}

void print_vector(const Json& vector, const std::string& unit, const char* what = "blocks") {
  std::printf("%s   %s   %d %s\n",
              vector["amplitude"].is_null()
                  ? "amplitude not known"
                  : with_confidence(vector["amplitude"], vector["amplitude_95"], "%.4f", unit).c_str(),
              vector["phase_deg"].is_null()
                  ? "phase not known"
                  : with_confidence(vector["phase_deg"], vector["phase_95_deg"], "%.2f", "deg").c_str(),
              vector["blocks"].get<int>(), what);
}

/// The same orders by the Vold-Kalman filter, where it was asked.
void print_crossing(const Json& order, const std::string& unit, bool by_speed) {
  if (!order.contains("vold_kalman") || order["vold_kalman"].is_null()) return;
  const Json& crossing = order["vold_kalman"];
  std::printf("  %24s Vold-Kalman  ", "");
  print_vector(crossing, unit, "values");
  if (crossing["together_s"] > 0.0)
    std::printf("  %24s not told: %.1f s of %.1f s beside another order\n", "",
                crossing["together_s"].get<double>(),
                crossing["together_s"].get<double>() + crossing["seconds"].get<double>());
  if (!by_speed) return;
  for (const Json& speed : crossing["by_speed"]) {
    std::printf("  %18.1f .. %.1f m/s  V-K  ", speed["from_m_s"].get<double>(),
                speed["to_m_s"].get<double>());
    print_vector(speed, unit, "values");
  }
}

void print_channel(const Json& channel, bool by_speed) {
  const auto name = channel["channel"].get<std::string>(), unit = channel["unit"].get<std::string>();
  for (const Json& order : channel["orders"]) {
    std::printf("  %-24s order %-6.4g ", name.c_str(), order["order"].get<double>());
    print_vector(order, unit);
    print_crossing(order, unit, by_speed);
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
  const auto remark = wheel["remark"].get<std::string>();
  if (!remark.empty()) std::printf("  %s\n", remark.c_str());
  for (const Json& channel : wheel["channels"]) print_channel(channel, by_speed);
}

/// Whether any vector has a confidence, or any magnitude is known where there are no vectors.
bool anything_known(const Json& wheels) {
  for (const Json& wheel : wheels)
    for (const Json& channel : wheel["channels"])
      for (const Json& order : channel["orders"])
        if (!order[wheel["angle_located"] ? "amplitude_95" : "amplitude"].is_null()) return true;
  return false;
}

/// Prints the orders that the analyser on the bus finds, once a second; with json an object on a line of its
/// own.
/// @return an ExitCode: whether any order was heard
int show_live_orders(const OrdersOptions& options) {
  constexpr std::chrono::seconds kEvery{1};
  const StopOnSignal signals;
  BusView view(options.url);
  Screen screen;
  const WallTime begin = WallClock::now();
  WallTime reported_at = begin;
  const auto over = [&] {
    return options.seconds > 0.0 &&
           std::chrono::duration<double>(WallClock::now() - begin).count() > options.seconds;
  };
  while (!signals.token().stop_requested() && !over()) {
    view.handle(std::chrono::milliseconds(100));
    for (const std::string& sentence : view.other_versions())
      std::fprintf(stderr, "rb orders: %s\n", sentence.c_str());
    if (WallClock::now() - reported_at < kEvery) continue;
    reported_at = WallClock::now();
    std::vector<std::string> lines;
    auto json = nlohmann::ordered_json::array();
    for (const auto& [key, report] : view.orders()) {
      if (options.json) json.push_back(order_report_json(report));
      for (std::string& line : order_lines(report)) lines.push_back(std::move(line));
    }
    if (lines.empty())
      lines.emplace_back(view.orders().empty() ? "waiting for an analyser that knows orders"
                                               : "the analyser knows no order well enough yet: drive on");
    if (!options.json)
      screen.draw(lines, true);
    else if (!json.empty()) {
      std::printf("%s\n", nlohmann::ordered_json{{"orders", json}}.dump().c_str());
      std::fflush(stdout);
    }
  }
  if (!view.orders().empty()) return kDone;
  std::fprintf(stderr, "rb orders: no analyser that tells orders was heard\n");
  return kAnswerIsNo;
}

int orders(const OrdersOptions& options) {
  if (options.live) return show_live_orders(options);
  if (options.folder.empty()) throw ConfigError("folder: missing; allowed: a recording, or --live");
  const RecordOrders found = [&] {
    const ReadingProgress progress(options.folder, 1);
    return orders_of_record(options.folder, options.wanted);
  }();
  warn_of_defects("orders", options.folder, found.defects);
  Json wheels = Json::array();
  for (const auto& rotor : found.rotor) wheels.push_back(rotor_json(found, *rotor, options.waterfall));
  if (options.json) {
    std::printf("%s\n", Json{{"wheels", wheels}}.dump().c_str());
  } else {
    std::printf("# peak amplitude, phase against the reference point, blocks of %d turns; ± is 95 %%\n",
                options.wanted.block_turns);
    for (const Json& wheel : wheels) print_wheel(wheel, options.wanted.channel.has_value());
  }
  if (anything_known(wheels)) return kDone;
  std::fprintf(stderr,
               "rb orders: too few whole turns at a known angle: no confidence below %d blocks of %d turns\n",
               MeanVector::kLeastVectors, options.wanted.block_turns);
  return kAnswerIsNo;
}

}  // namespace

void add_orders(CLI::App& app, int& code) {
  auto options = std::make_shared<OrdersOptions>();
  CLI::App* command = app.add_subcommand(
      "orders",
      "Order vectors (amplitude, phase against the reference point) and order spectra of a recording");
  CLI::Option* const folder = command->add_option("folder", options->folder, "the recording");
  CLI::Option* const live = command->add_flag(
      "--live", options->live, "what the analyser on the bus finds of orders 1 and 2, once a second");
  live->excludes(folder);
  add_bus_url(*command, options->url)->needs(live);
  command->add_option("--seconds", options->seconds, "stop after this long; 0: when interrupted")
      ->needs(live)
      ->check(seconds_or_zero());
  CLI::Option* const wheel = command->add_option("--wheel", options->wanted.wheel,
                                                 "its angle only; default: every wheel with an encoder");
  command
      ->add_option("--rotor", options->wanted.rotor,
                   "instead of wheels, what they turn: a [[rotor]] of vehicle.toml")
      ->excludes(wheel);
  CLI::Option* const channel = command->add_option(
      "--channel", options->wanted.channel,
      "this channel only, of any node, by classes of speed, too; default: every acceleration of the nodes "
      "that read the encoder");
  command->add_flag("--all-nodes", options->wanted.all_nodes, "every acceleration of every node")
      ->excludes(channel);
  command->add_option("--order", options->wanted.order, "orders of the vectors")->capture_default_str();
  command
      ->add_option("--turns", options->wanted.block_turns,
                   "of a block: fewer for a record of less than a hundred turns; no order is below 1 / turns")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  command
      ->add_option("--vold-kalman", options->wanted.vold_kalman_hz,
                   "also all wheels together by the Vold-Kalman filter of this bandwidth, Hz (0.5 is usual): "
                   "orders that cross are told apart, as a check of the vectors")
      ->check(number_within(0.05, 20.0));
  CLI::Option* const json = command->add_flag("--json", options->json, "one JSON object on standard output");
  command->add_flag("--waterfall", options->waterfall, "with --json: a spectrum for each class of speed, too")
      ->needs(json);
  // The analyser has chosen already.
  for (const char* const of_record : {"--wheel", "--rotor", "--channel", "--all-nodes", "--order", "--turns",
                                      "--vold-kalman", "--waterfall"})
    live->excludes(command->get_option(of_record));
  command->callback([options, &code] { code = orders(*options); });
}

}  // namespace roadbalance
