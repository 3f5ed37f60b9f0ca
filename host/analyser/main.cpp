#include <CLI/CLI.hpp>
#include <exception>
#include <filesystem>
#include <string>
#include <system_error>

#include "common/command_line/bus_url.hpp"
#include "common/command_line/manual.hpp"
#include "common/command_line/run_program.hpp"
#include "common/config/section.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/analyser/analyser.hpp"
#include "host/analyser/follow_recordings.hpp"

int main(int argc, char** argv) {
  const roadbalance::StopOnSignal signals;
  roadbalance::AnalyserOptions options;
  options.on_warning = [](const std::string& sentence) { roadbalance::report("rb-analyser", sentence); };
  CLI::App app("Turns a growing record and the live bus into levels, spectra, identification and balance.",
               "rb-analyser");
  roadbalance::add_bus_url(app, options.url);
  auto* record = app.add_option("--record", options.record, "folder that rb-recorder writes");
  std::filesystem::path recordings;
  app.add_option("--vehicle", options.vehicle,
                 "with --recordings: the recorder's vehicle.toml, by which levels are shown while nothing is "
                 "recorded; when another one beside it is chosen, by that")
      ->check(CLI::ExistingFile);
  app.add_option("--recordings", recordings,
                 "folder of rb-recorder --recordings: follows each recording in turn")
      ->excludes(record);
  app.add_option("--before", options.before,
                 "finished recording of the drive before weights were fitted: what they have done is told; "
                 "with --recordings the newest one whose vehicle.toml has other [[wheel.weight]]")
      ->check(CLI::ExistingDirectory);
  app.add_flag("--exit-at-end", options.exit_at_end,
               "exit once every node has ended and the last estimate is out");
  roadbalance::add_version(app);
  roadbalance::add_manual(app);
  try {
    app.parse(argc, argv);
    if (!options.vehicle.empty() && recordings.empty())
      throw roadbalance::ConfigError("--vehicle goes with --recordings: a recording tells its own");
    if (options.record.empty() && recordings.empty())
      throw roadbalance::ConfigError("--record or --recordings must say what to analyse");
    if (!recordings.empty()) {
      roadbalance::follow_recordings(signals.token(), recordings, options);
      return 0;
    }
    if (!std::filesystem::exists(options.record))
      roadbalance::report("rb-analyser", "waiting for a record in " + options.record.string());
    roadbalance::run_analyser(signals.token(), options);
    return 0;
  } catch (const std::exception& error) {
    return roadbalance::report_failure(app, error);
  }
}
