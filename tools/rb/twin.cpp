#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <system_error>

#include "common/command_line/bus_url.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "common/process/stop_on_signal.hpp"
#include "common/record/part.hpp"
#include "host/analyser/identify_record.hpp"
#include "host/analyser/recorded_vehicle.hpp"
#include "host/analyser/twin_record.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/defects.hpp"
#include "tools/rb/reading_progress.hpp"
#include "tools/rb/twin_live.hpp"
#include "tools/rb/twin_table.hpp"

namespace roadbalance {
namespace {

struct TwinOptions {
  TwinRequest request;
  std::string folder, csv;
  std::optional<double> to_s;
  LiveTwinOptions live{};
  bool is_live = false;
  bool nominal = false;
  bool json = false;
};

/// Measured and predicted of every channel, a row each sample; a cell of what is not predicted is empty.
class CsvFile {
 public:
  explicit CsvFile(const std::string& name) {
    if (name.empty()) return;
    part_.emplace(name, Part::Kind::kFile);
    file_.open(part_->part());
    check();
  }

  void begin(const VehicleConfig& vehicle, const TwinChannels& channels) {
    if (!part_) return;
    parts_ = channels;
    std::string units = "s";
    file_ << "time_s";
    for (const TwinChannels::One& one : channels.channel) {
      const std::string& name = vehicle.node[static_cast<std::size_t>(one.node)]
                                    .channel[static_cast<std::size_t>(one.channel)]
                                    .name;
      file_ << ',' << name << "_measured," << name << "_predicted";
      units += ",m/s^2,m/s^2";
    }
    file_ << '\n' << units << '\n';
  }

  void add(double at_s, const TwinSample& sample) {
    if (!part_) return;
    char text[48];
    std::snprintf(text, sizeof text, "%.6f", at_s);
    file_ << text;
    for (Eigen::Index c = 0; c < sample.measured.size(); ++c) {
      const auto part = static_cast<std::size_t>(parts_.channel[static_cast<std::size_t>(c)].part);
      std::snprintf(text, sizeof text, ",%.6g,", sample.measured(c));
      file_ << text;
      if (sample.state[part] != TwinState::kTold) continue;
      std::snprintf(text, sizeof text, "%.6g", sample.predicted(c));
      file_ << text;
    }
    file_ << '\n';
  }

  void close() {
    if (!part_) return;
    file_.close();
    check();
    part_->keep();
  }

 private:
  void check() const {
    if (!file_) throw std::system_error(errno, std::generic_category(), "write " + part_->part().string());
  }

  std::optional<Part> part_;
  std::ofstream file_;
  TwinChannels parts_;
};

int twin(TwinOptions options) {
  options.live.json = options.json;
  if (options.is_live) return show_live_twin(options.live);
  if (options.folder.empty()) throw ConfigError("folder: missing; allowed: a recording, or --live");
  const StopOnSignal signals;
  options.request.folder = options.folder;
  if (options.to_s) options.request.to_s = *options.to_s;
  if (!(options.request.from_s < options.request.to_s)) throw ConfigError("--to: must be behind --from");
  if (options.nominal) options.request.car = TwinCar::nominal(vehicle_of_recording(options.folder));
  CsvFile csv(options.csv);
  std::optional<ReadingProgress> progress(std::in_place, options.folder, 2);
  const RecordedTwin found = twin_of_record(
      options.request,
      [&](const VehicleConfig& vehicle, const TwinChannels& channels) { csv.begin(vehicle, channels); },
      [&](double at_s, const TwinSample& sample) { csv.add(at_s, sample); }, signals.token());
  progress.reset();
  csv.close();
  warn_of_defects("twin", options.folder, found.defects);
  if (!found.obstacle.empty()) std::fprintf(stderr, "rb twin: %s\n", found.obstacle.c_str());
  if (options.json)
    std::printf("%s\n", twin_json(found).dump().c_str());
  else
    for (const std::string& line : twin_lines(found)) std::printf("%s\n", line.c_str());
  const bool any = std::ranges::any_of(found.seconds, [](int seconds) { return seconds > 0; });
  return any ? kDone : kAnswerIsNo;
}

}  // namespace

void add_twin(CLI::App& app, int& code) {
  auto options = std::make_shared<TwinOptions>();
  CLI::App* command = app.add_subcommand(
      "twin", "Simulates the car beside a recording: predicted and measured acceleration of each channel");
  CLI::Option* const folder = command->add_option("folder", options->folder, "the recording");
  CLI::Option* const vehicle =
      command->add_option("--vehicle", options->live.vehicle, "with --live: file by which the nodes measure")
          ->check(CLI::ExistingFile);
  CLI::Option* const live =
      command->add_flag("--live", options->is_live, "beside the nodes on the bus, told once a second")
          ->excludes(folder)
          ->needs(vehicle);
  vehicle->needs(live);
  add_bus_url(*command, options->live.url)->needs(live);
  command
      ->add_option("--seconds", options->live.seconds,
                   "with --live, stop after this long; 0: when interrupted")
      ->needs(live)
      ->check(seconds_or_zero());
  command
      ->add_option("--from", options->request.from_s,
                   "begin of the account, s from the recording's first sample")
      ->needs(folder)
      ->check(CLI::NonNegativeNumber);
  command->add_option("--to", options->to_s, "its end, s, not included")
      ->needs(folder)
      ->check(CLI::NonNegativeNumber);
  command
      ->add_flag("--nominal", options->nominal,
                 "the car as vehicle.toml has it, wheels in balance, not as this drive tells it")
      ->needs(folder);
  command
      ->add_flag("--refine", options->request.refine,
                 "clocks and wheels' angles computed again, as of rb identify")
      ->needs(folder);
  command
      ->add_option("--csv", options->csv,
                   "file to make: measured and predicted of every channel, a row each sample")
      ->needs(folder);
  command->add_flag("--json", options->json, "one JSON object on standard output, with --live one a second");
  command->footer(
      "The body is predicted from the four wheels' carriers, each axle's wheels from the road that the other "
      "axle tells; sensors on the body are only compared. Explained: 1 less residual over measured mean "
      "square. At most: what it would be were gain and phase of the prediction right at each frequency "
      "(coherence).\n"
      "Exit codes: 0 there is an account of some channel, 1 of none, 2 usage, 4 cannot read or write.");
  command->callback([options, &code] { code = twin(*options); });
}

}  // namespace roadbalance
