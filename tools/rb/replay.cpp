#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/quiet_port.hpp"
#include "common/command_line/bus_url.hpp"
#include "common/config/section.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/recording/replay/replay_record.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/progress_line.hpp"
#include "tools/views/recording_defects.hpp"

namespace roadbalance {
namespace {

struct ReplayOptions {
  std::string folder;
  std::string speed = "1";
  std::string url;
  bool json = false;
};

std::optional<double> speed_of(const std::string& text) {
  if (text == "max") return std::nullopt;
  constexpr double kLeast = 1e-3, kMost = 1e4;
  std::size_t used = 0;
  double speed = 0.0;
  try {
    speed = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size() || !(speed >= kLeast && speed <= kMost))
    throw ConfigError("--speed: " + text + ": allowed: 0.001 .. 10000, or max");
  return speed;
}

int replay(const ReplayOptions& options) {
  const StopOnSignal signals;
  const auto speed = speed_of(options.speed);
  const RecordingSurvey survey = survey_recording(options.folder, signals.token());
  // Blocks of another time among those that are measured now would be taken for a node's.
  constexpr std::chrono::milliseconds kListen{1500};  // a recorder that waits sends a message once a second
  if (!is_quiet(options.url, kListen))
    throw std::runtime_error("a node or a recorder is on this bus; --url names another for the replay");
  Bus bus(options.url);
  const ReplayReport report = [&] {
    ProgressLine line;
    std::uint64_t bytes = 0;
    const auto publish = [&](const std::string& channel, std::span<const std::uint8_t> data) {
      bytes += data.size();
      return bus.publish(channel, data);
    };
    return replay_record(
        options.folder, survey, speed, publish, signals.token(),
        [&](double done_s, double of_s) { line.show(of_s > 0.0 ? done_s / of_s : 1.0, bytes); });
  }();
  const bool stopped = signals.token().stop_requested();
  if (options.json)
    std::printf("%s\n", nlohmann::ordered_json({{"events", report.events},
                                                {"bytes", report.bytes},
                                                {"unsent", report.unsent},
                                                {"seconds", report.drive_s},
                                                {"late_rms_s", report.late_rms_s},
                                                {"late_most_s", report.late_most_s},
                                                {"damaged_bytes", survey.defects.damaged_bytes},
                                                {"blocks_refused", survey.defects.refused_blocks},
                                                {"blocks_missing", survey.defects.missing_blocks},
                                                {"stopped", stopped}})
                            .dump()
                            .c_str());
  else
    std::printf(
        "%lld events of %.3f s, %.1f MB; %.3f ms late (rms), %.3f ms at most; %lld could not be sent\n",
        static_cast<long long>(report.events), report.drive_s, 1e-6 * static_cast<double>(report.bytes),
        1e3 * report.late_rms_s, 1e3 * report.late_most_s, static_cast<long long>(report.unsent));
  warn_of_defects("replay", options.folder, survey.defects);
  if (survey.defects.any()) return kAnswerIsNo;
  return report.unsent == 0 && !stopped ? kDone : kIncomplete;
}

}  // namespace

void add_replay(CLI::App& app, int& code) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command =
      app.add_subcommand("replay", "Plays a recording on the bus, as lcm-logplayer plays its segments");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_option("--speed", options->speed, "seconds of the drive a second, or max")
      ->capture_default_str();
  add_bus_url(*command, options->url);
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->footer(
      "rb-analyser --record DIR beside it shows the drive on the page again. Refused on a bus with a node or "
      "a "
      "recorder. Who cannot keep up with max loses: nobody repairs a replay.\n"
      "Exit codes: 0 done, 3 stopped, or events could not be sent, 1 the recording is damaged and the rest "
      "was "
      "played, 2 usage, 4 cannot read, or no bus.");
  command->callback([options, &code] { code = replay(*options); });
}

}  // namespace roadbalance
