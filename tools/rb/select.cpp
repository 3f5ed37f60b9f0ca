#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "common/config/section.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/recording/recorded_vehicle.hpp"
#include "host/recording/subset/subset_recording.hpp"
#include "tools/rb/command.hpp"
#include "tools/views/recording_defects.hpp"
#include "tools/rb/progress_line.hpp"
#include "tools/views/verification_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct SubsetOptions {
  SubsetRequest request;
  std::string folder, output;
  std::string speed;  ///< km/h, "LEAST:MOST"
  double rate_hz = 0.0;
  bool json = false;
};

std::optional<double> kilometres_per_hour(const std::string& text, const std::string& whole) {
  if (text.empty()) return std::nullopt;
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size() || !std::isfinite(value))
    throw ConfigError("--speed: " + whole + ": allowed: LEAST:MOST in km/h, one of them may be left out");
  return value / 3.6;
}

void take_speed(const std::string& speed, TimeChoice& time) {
  if (speed.empty()) return;
  const auto colon = speed.find(':');
  if (colon == std::string::npos || speed.size() == 1)
    throw ConfigError("--speed: " + speed + ": allowed: LEAST:MOST in km/h, one of them may be left out");
  time.least_m_s = kilometres_per_hour(speed.substr(0, colon), speed);
  time.most_m_s = kilometres_per_hour(speed.substr(colon + 1), speed);
  if (time.least_m_s && time.most_m_s && *time.most_m_s <= *time.least_m_s)
    throw ConfigError("--speed: " + speed + ": the second is not above the first");
}

/// The rate that is wanted must be the recording's divided by a whole number.
int factor_of(double rate_hz, const std::string& folder) {
  const double recorded_hz = vehicle_of_recording(folder).node.front().rate_hz;
  const double factor = recorded_hz / rate_hz;
  constexpr double kNearEnough = 1e-6;  // an import's rate is that of its stamps
  if (factor < 2.0 - kNearEnough || std::abs(factor - std::round(factor)) > kNearEnough * factor) {
    char text[160];
    std::snprintf(text, sizeof text, "--rate: %.9g: allowed: %.9g Hz divided by 2, 3, 4 ...", rate_hz,
                  recorded_hz);
    throw ConfigError(text);
  }
  return static_cast<int>(std::lround(factor));
}

Json report_json(const SubsetOptions& options, const SubsetReport& report) {
  Json pieces = Json::array(), left_out = Json::array();
  for (const Piece& piece : report.pieces)
    pieces.push_back(
        {{"from_s", static_cast<double>(piece.from_ns) * 1e-9},
         {"to_s", piece.to_ns == Piece::kEver ? Json() : Json(static_cast<double>(piece.to_ns) * 1e-9)}});
  for (const auto& part : report.left_out)
    left_out.push_back({{"node", part.node}, {"samples", part.samples}});
  return {{"folder", options.output},
          {"made_of", report.made_of},
          {"factor", options.request.factor},
          {"bytes", report.bytes},
          {"pieces", pieces},
          {"left_out", left_out},
          {"damaged_bytes", report.defects.damaged_bytes},
          {"blocks_refused", report.defects.refused_blocks},
          {"blocks_missing", report.defects.missing_blocks},
          {"record", verification_json(report.verification)}};
}

void tell(const SubsetOptions& options, const SubsetReport& report) {
  for (const auto& part : report.left_out)
    std::fprintf(stderr, "node %s: its clock is not known, %lld samples left out\n", part.node.c_str(),
                 static_cast<long long>(part.samples));
  if (options.json) {
    std::printf("%s\n", report_json(options, report).dump().c_str());
    return;
  }
  std::printf("%s: %s, %.1f MB\n", options.output.c_str(), report.made_of.c_str(),
              1e-6 * static_cast<double>(report.bytes));
  if (report.pieces.size() > 1) std::printf("%zu stretches of time\n", report.pieces.size());
  print_verification(report.verification);
}

int run_subset(SubsetOptions options) {
  const StopOnSignal signals;
  options.request.folder = options.folder;
  options.request.output = options.output;
  take_speed(options.speed, options.request.time);
  if (options.rate_hz > 0.0) options.request.factor = factor_of(options.rate_hz, options.folder);
  const SubsetReport report = [&] {
    ProgressLine line;
    return subset_recording(options.request, signals.token(), [&](std::uint64_t done, std::uint64_t of) {
      line.show(of > 0 ? static_cast<double>(done) / static_cast<double>(of) : 1.0, done);
    });
  }();
  warn_of_defects(options.request.factor > 1 ? "reduce" : "select", options.folder, report.defects);
  tell(options, report);
  if (report.defects.any()) return kAnswerIsNo;
  return report.verification.verdict == Verdict::kComplete && report.left_out.empty() ? kDone : kIncomplete;
}

CLI::App* add_subset(CLI::App& app, const char* name, const char* about,
                     const std::shared_ptr<SubsetOptions>& options) {
  CLI::App* command = app.add_subcommand(name, about);
  TimeChoice& time = options->request.time;
  ChannelChoice& choice = options->request.choice;
  command->add_option("folder", options->folder, "the recording; it stays as it is")->required();
  command->add_option("-o,--output", options->output, "the new recording: a new or empty folder")->required();
  command->add_option("--from", time.from_s,
                      "begin, s from the recording's first sample, or from --from-mark");
  command->add_option("--to", time.to_s, "end, s, not included; from the first sample, or from --to-mark");
  command->add_option("--from-mark", time.from_mark, "number of the mark that --from counts from");
  command->add_option("--to-mark", time.to_mark, "number of the mark that --to counts from");
  command->add_option("--speed", options->speed,
                      "LEAST:MOST in km/h: only while the car is as fast; one of them may be left out");
  command->add_flag("--clean", time.clean,
                    "only where all nodes chosen have all samples, in range, and know all angles");
  command->add_option("--at-least", time.least_s, "shorter stretches of --speed and --clean are left out, s")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  command->add_option("--nodes", choice.nodes, "names of nodes; all if not given")->delimiter(',');
  command
      ->add_option("--channels", choice.channels,
                   "names of channels, or of nodes for all of theirs; all if not given. Wheel angles stay")
      ->delimiter(',');
  command->add_flag("--json", options->json, "one JSON object on standard output");
  return command;
}

constexpr const char* kExitCodes =
    "Exit codes: 0 the new recording is complete, 3 samples are missing in it as they were, and declared, or "
    "the rest of the recording is in another folder, 1 the recording is damaged and what is missing by that "
    "is declared, 2 usage, or nothing is left, 4 cannot read or write.";

}  // namespace

void add_select(CLI::App& app, int& code) {
  auto options = std::make_shared<SubsetOptions>();
  CLI::App* command =
      add_subset(app, "select", "Makes a recording of a part of another: time, nodes, channels", options);
  command->footer(
      std::string("Samples are the same bit for bit; marks, clocks and gaps with their causes come "
                  "along. Each stretch is an epoch of its own.\n") +
      kExitCodes);
  command->callback([options, &code] { code = run_subset(*options); });
}

void add_reduce(CLI::App& app, int& code) {
  auto options = std::make_shared<SubsetOptions>();
  options->request.factor = 0;
  CLI::App* command =
      add_subset(app, "reduce", "Makes a recording of fewer samples a second, or of a part of it", options);
  constexpr int kMostFactor = 1000;
  CLI::Option* factor =
      command->add_option("--factor", options->request.factor, "every so many samples one is left")
          ->check(CLI::Range(2, kMostFactor));
  CLI::Option* rate = command->add_option("--rate", options->rate_hz, "samples a second that are left, Hz")
                          ->check(CLI::PositiveNumber);
  factor->excludes(rate);
  command->footer(
      std::string(
          "Behind a low-pass of linear phase without delay: up to 0.4 of the new rate all passes to 0.0001 "
          "dB, from half of it on 98 dB less, so that nothing folds. It reaches 34 new samples to each "
          "side, and never across a gap: so much is left out at the beginning and end, and gaps grow by "
          "it. Wheel angles pass the same filter; edges and signals stay as they are.\n") +
      kExitCodes);
  command->callback([options, factor, rate, &code] {
    if (factor->count() + rate->count() == 0) throw ConfigError("rb reduce: --factor or --rate is required");
    code = run_subset(*options);
  });
}

}  // namespace roadbalance
