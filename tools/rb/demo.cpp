#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "common/config/validators.hpp"
#include "common/process/stop_on_signal.hpp"
#include "sim/truth.hpp"
#include "tools/demonstration/demo_page.hpp"
#include "tools/demonstration/demo_plan.hpp"
#include "tools/demonstration/demo_report.hpp"
#include "tools/demonstration/demo_start.hpp"
#include "tools/demonstration/demo_team.hpp"
#include "tools/rb/command.hpp"
#include "tools/views/bus_view.hpp"
#include "tools/views/readout.hpp"

namespace roadbalance {
namespace {

constexpr std::chrono::milliseconds kStep{50};

/// Ends a demo whose programs do not understand each other: they would wait for each other for ever.
class Start {
 public:
  explicit Start(const VehicleConfig& vehicle) : vehicle_(vehicle) {}

  /// @throws std::runtime_error naming who is of another version, or who has not begun in time
  void check(BusView& view, const DemoTeam& team) {
    if (const auto other = view.other_versions(); !other.empty()) throw std::runtime_error(other.front());
    if (begun_) return;
    const std::string idle = who_is_idle(vehicle_, view);
    begun_ = idle.empty();
    if (!begun_ && WallClock::now() - begin_ > kDemoStart)
      throw std::runtime_error(idle + " after " + std::to_string(kDemoStart.count()) + " s" +
                               team.last_words());
  }

 private:
  const VehicleConfig& vehicle_;
  const WallTime begin_ = WallClock::now();
  bool begun_ = false;
};

int demo(const DemoOptions& options) {
  const StopOnSignal signals;
  const WallTime begin = WallClock::now();
  const DemoPlan plan(options);
  const sim::Truth truth = sim::truth_of(options.scenario, options.seed, plan.vehicle());
  BusView view(plan.url());
  Screen screen;
  std::optional<DemoPage> page;
  if (!options.headless) {
    page.emplace(plan);
    const std::string where = page->where();
    std::printf(
        "A simulated car drives %.0f s at %s times real time (assumption: tyres without radial force "
        "variation).\n%s\n",
        options.drive_seconds, options.rate.c_str(), where.c_str());
  }

  const auto team = options.threads ? start_threads(plan) : start_processes(plan);
  Start start(plan.vehicle());
  while (team->working()) {
    if (signals.token().stop_requested()) {
      std::fprintf(stderr, "rb demo: interrupted\n");
      return kAnswerIsNo;
    }
    const bool news = view.handle(kStep);
    start.check(view, *team);
    if (!options.headless) screen.draw(demo_lines(view, truth), news);
  }
  const std::vector<NodeReport> recorded = team->finish();
  while (view.handle(kStep)) continue;  // what is still in the socket
  const double wall_s = std::chrono::duration<double>(WallClock::now() - begin).count();

  nlohmann::ordered_json report = demo_report(view, truth, plan, recorded);
  report["wall_s"] = wall_s;
  if (!options.json) {
    screen.draw(demo_lines(view, truth), true);
    for (const auto& node : report["nodes"])
      std::printf("%s: %lld samples sent, %lld recorded, %lld gaps, %lld blocks repaired\n",
                  node["name"].get<std::string>().c_str(), node["samples_sent"].get<long long>(),
                  node["samples_recorded"].get<long long>(), node["gaps"].get<long long>(),
                  node["repaired"].get<long long>());
    std::printf("%.0f s of driving in %.1f s\n", report["drive_s"].get<double>(), wall_s);
    if (!options.record.empty()) std::printf("the recording is in %s\n", options.record.c_str());
  }
  if (options.json) std::printf("%s\n", report.dump().c_str());
  if (const std::string obstacle = demo_obstacle(view); !obstacle.empty())
    std::fprintf(stderr, "rb demo: no wheel was identified: %s\n", obstacle.c_str());
  if (page) page->stay(signals.token());
  return demo_exit_code(report);
}

}  // namespace

void add_demo(CLI::App& app, int& code) {
  auto options = std::make_shared<DemoOptions>();
  CLI::App* command =
      app.add_subcommand("demo", "Balances a simulated car, with the truth beside the result");
  command->add_option("--seed", options->seed, "draws car, road and noise")
      ->check(seed_number())
      ->capture_default_str();
  command->add_option("--drive-seconds", options->drive_seconds, "length of the drive")
      ->check(drive_length())
      ->capture_default_str();
  command->add_option("--rate", options->rate, "times real time, or max")
      ->check(rate_of_time())
      ->capture_default_str();
  command->add_option("--record", options->record, "keep the recording in this new folder");
  command->add_option("--vehicle", options->vehicle, "another vehicle.toml");
  command->add_option("--scenario", options->scenario, "another scenario.toml");
  CLI::Option* const port =
      command->add_option("--port", options->port, "TCP port of the page for a browser; 0: a free one")
          ->check(CLI::Range(0, 65'535));
  command->add_option("--bus-port", options->bus_port, "UDP port of the bus; 0: a free one")
      ->check(CLI::Range(0, 65'535));
  command->add_flag("--headless", options->headless, "the result alone, at the end, and no page")
      ->excludes(port);
  command->add_flag("--json", options->json, "one JSON object on standard output; implies --headless")
      ->excludes(port);
  command->add_flag("--threads", options->threads, "recorder, analyser and nodes as threads of this program");
  command->callback([options, &code] {
    options->headless = options->headless || options->json;
    code = demo(*options);
  });
}

}  // namespace roadbalance
