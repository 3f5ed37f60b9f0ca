#include "tools/rb/live_orders_view.hpp"

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "common/process/stop_on_signal.hpp"
#include "tools/rb/bus_view.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/order_lines.hpp"
#include "tools/rb/readout.hpp"

namespace roadbalance {

int show_live_orders(const LiveOrdersOptions& options) {
  constexpr std::chrono::seconds kEvery{1};
  const StopOnSignal signals;
  BusView view(options.url);
  Screen screen;
  const WallTime begin = WallClock::now();
  WallTime said_at = begin;
  const auto over = [&] {
    return options.seconds > 0.0 &&
           std::chrono::duration<double>(WallClock::now() - begin).count() > options.seconds;
  };
  while (!signals.token().stop_requested() && !over()) {
    view.handle(std::chrono::milliseconds(100));
    for (const std::string& sentence : view.other_versions())
      std::fprintf(stderr, "rb orders: %s\n", sentence.c_str());
    if (WallClock::now() - said_at < kEvery) continue;
    said_at = WallClock::now();
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

}  // namespace roadbalance
