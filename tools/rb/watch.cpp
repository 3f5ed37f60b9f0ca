#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/process/stop_on_signal.hpp"
#include "host/recorder/status_line.hpp"
#include "tools/rb/bus_view.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/readout.hpp"
#include "tools/study/wheels_json.hpp"

namespace roadbalance {
namespace {

struct WatchOptions {
  std::string url = default_bus_url();
  double seconds = 0;
  bool json = false;
};

std::vector<std::string> draw(const BusView& view) {
  std::vector<std::string> lines;
  if (view.identification()) lines.push_back(identification_line(*view.identification()));
  for (const auto& balance : view.balance()) {
    if (!balance) continue;
    const std::string advice = advice_line(*balance);
    lines.push_back(balance_line(*balance) + (advice.empty() ? "" : "   " + advice));
  }
  for (const auto& [incarnation, status] : view.recorders()) {
    lines.push_back("recorder: " + status_line(status));
    for (const auto& alarm : alarms(status)) lines.push_back("  ! " + alarm);
  }
  if (view.recorders().size() > 1)
    lines.push_back("  ! more than one recorder: a node obeys only one of them");
  for (const auto& [node, heartbeat] : view.heartbeats()) lines.push_back(node_line(heartbeat));
  for (const auto& [node, level] : view.levels()) {
    auto node_lines = level_lines(level);
    for (std::int32_t c = 0; c < kAccelerations; ++c)
      if (const auto line = view.highest_lines().find({node, c}); line != view.highest_lines().end())
        if (line->second.density > 0.0) {
          char text[64];
          std::snprintf(text, sizeof text, "  strongest at %.1f Hz", line->second.frequency_hz);
          node_lines[static_cast<std::size_t>(c) + 1] += text;
        }
    lines.insert(lines.end(), node_lines.begin(), node_lines.end());
  }
  if (lines.empty()) lines.push_back("waiting for an analyser on the bus");
  return lines;
}

int watch(const WatchOptions& options) {
  const StopOnSignal signals;
  BusView view(options.url);
  Screen screen;
  const WallTime begin = WallClock::now();
  const auto over = [&] {
    return options.seconds > 0.0 &&
           std::chrono::duration<double>(WallClock::now() - begin).count() > options.seconds;
  };
  while (!signals.token().stop_requested() && !over()) {
    const bool news = view.handle(std::chrono::milliseconds(100));
    if (!options.json) {
      screen.draw(draw(view), news);
      continue;
    }
    if (!news || !view.identification()) continue;
    std::array<Balance, kWheels> balance;
    for (std::size_t w = 0; w < kWheels; ++w) balance[w] = view.balance()[w].value_or(Balance{});
    std::printf(
        "%s\n",
        nlohmann::ordered_json{{"wheels", wheels_json(*view.identification(), balance)}}.dump().c_str());
    std::fflush(stdout);
  }
  if (view.identification()) return kDone;
  std::fprintf(stderr, "rb watch: %s\n", view.levels().empty() ? "no analyser heard" : "no estimate heard");
  return kAnswerIsNo;
}

}  // namespace

void add_watch(CLI::App& app, int& code) {
  auto options = std::make_shared<WatchOptions>();
  CLI::App* command =
      app.add_subcommand("watch", "Shows levels and balance from the bus, as the analyser sends them");
  command->add_option("--url", options->url, "LCM address of the bus")->capture_default_str();
  command->add_option("--seconds", options->seconds, "stop after this long; 0: when interrupted")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--json", options->json,
                    "JSON lines: one object, on a line of its own, for each new estimate");
  command->callback([options, &code] { code = watch(*options); });
}

}  // namespace roadbalance
