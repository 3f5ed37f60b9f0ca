#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "common/command_line/bus_url.hpp"
#include "common/config/validators.hpp"
#include "common/process/stop_on_signal.hpp"
#include "tools/rb/command.hpp"
#include "tools/views/bus_view.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/watch_json.hpp"
#include "tools/views/watch_lines.hpp"

namespace roadbalance {
namespace {

struct WatchOptions {
  std::string url;
  double seconds = 0;
  bool json = false;
};

/// Where lines are not drawn in place: changes of state are printed so often at the most, and a state that
/// goes on so often at the least.
constexpr std::chrono::seconds kAtMostEvery{1};
constexpr std::chrono::seconds kAtLeastEvery{10};

int watch(const WatchOptions& options) {
  const StopOnSignal signals;
  BusView view(options.url);
  Screen screen;
  const WallTime begin = WallClock::now();
  WallTime reported_at{};
  bool changed = false;
  const auto over = [&] {
    return options.seconds > 0.0 &&
           std::chrono::duration<double>(WallClock::now() - begin).count() > options.seconds;
  };
  while (!signals.token().stop_requested() && !over()) {
    bool news = view.handle(std::chrono::milliseconds(100));
    for (const std::string& sentence : view.other_versions())
      std::fprintf(stderr, "rb watch: %s\n", sentence.c_str());
    const auto silence = WallClock::now() - reported_at;
    changed = changed || view.state_changed();
    news = news || (changed && silence >= kAtMostEvery) || silence >= kAtLeastEvery;
    if (news) {
      reported_at = WallClock::now();
      changed = false;
    }
    if (!options.json) {
      screen.draw(watch_lines(view), news);
    } else if (news && view.heard_anything()) {
      std::printf("%s\n", watch_json(view).dump().c_str());
      std::fflush(stdout);
    }
  }
  if (view.identification()) return kDone;
  std::fprintf(stderr, "rb watch: %s\n", view.levels().empty() ? "no analyser heard" : "no estimate heard");
  return kAnswerIsNo;
}

}  // namespace

void add_watch(CLI::App& app, int& code) {
  auto options = std::make_shared<WatchOptions>();
  CLI::App* command =
      app.add_subcommand("watch", "Shows levels, balance, recorders, nodes and their clocks from the bus");
  add_bus_url(*command, options->url);
  command->add_option("--seconds", options->seconds, "stop after this long; 0: when interrupted")
      ->check(seconds_or_zero());
  command->add_flag("--json", options->json,
                    "JSON lines: an object for each new estimate, each change of a recorder, node or clock, "
                    "and every 10 s");
  command->callback([options, &code] { code = watch(*options); });
}

}  // namespace roadbalance
