#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>

#include "common/bus/bus.hpp"
#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/command_line/bus_url.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "common/process/stop_on_signal.hpp"
#include "common/record/part.hpp"
#include "common/types/clocks.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/analysis/twin/live_twin.hpp"
#include "host/analysis/twin/twin_record.hpp"
#include "host/recording/formats/csv_text.hpp"
#include "host/recording/in_sequence.hpp"
#include "host/recording/recorded_vehicle.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/reading_progress.hpp"
#include "tools/views/readout.hpp"
#include "tools/views/recording_defects.hpp"
#include "tools/views/twin_table.hpp"

namespace roadbalance {
namespace {

struct LiveTwinOptions {
  std::string url;
  std::string vehicle;   ///< vehicle.toml by which the nodes measure
  double seconds = 0.0;  ///< 0: until interrupted
  bool json = false;
};

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
      file_ << ',' << name_cell(name + "_measured") << ',' << name_cell(name + "_predicted");
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
      if (sample.state[part] != TwinState::kPredicted) continue;
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

/// Passes the messages of the bus to the twin.
class Listener {
 public:
  Listener(const LiveTwinOptions& options, const VehicleConfig& vehicle)
      : options_(options),
        bus_(options.url, {.ahead_bytes = kAhead}),
        twin_(vehicle, [this](const TwinSecond& s) { tell(s); }) {
    now_.vehicle = vehicle;
    now_.channels = twin_.channels();
    now_.seconds.assign(now_.channels.channel.size(), 0);
    bus_.subscribe("RB_BLOCK_.*", [this](std::string_view, auto bytes) {
      if (accept(bytes, *block_) == Refusal::kNone)
        sequence_.add(*block_, [this](const SealedBlock& block) { twin_.consume(block); });
    });
    bus_.subscribe("RB_CLOCK_.*", [this](std::string_view, auto bytes) {
      if (const auto fit = decode_clock_fit(bytes)) twin_.consume(*fit);
    });
    bus_.subscribe(kIdentificationChannel, [this](std::string_view, auto bytes) {
      if (const auto identification = decode_identification(bytes)) twin_.take(*identification);
    });
    bus_.subscribe(kBalanceChannel, [this](std::string_view, auto bytes) {
      if (const auto balance = decode_balance(bytes)) twin_.take(*balance);
    });
  }

  void listen() {
    bus_.handle(std::chrono::milliseconds(100));
    for (const std::string& sentence : bus_.other_versions())
      std::fprintf(stderr, "rb twin: %s\n", sentence.c_str());
    if (const std::string why = twin_.no_common_time(); why != reported_) {
      if (!why.empty()) std::fprintf(stderr, "rb twin: %s\n", why.c_str());
      reported_ = why;
    }
    if (const auto missing = sequence_.missing(); missing > missed_) {
      std::fprintf(stderr, "rb twin: %lld blocks have not come by themselves\n",
                   static_cast<long long>(missing - missed_));
      missed_ = missing;
    }
  }

  bool told_any() const {
    return std::ranges::any_of(now_.seconds, [](int seconds) { return seconds > 0; });
  }

 private:
  void tell(const TwinSecond& second) {
    now_.total.clear();
    now_.car = twin_.car();
    for (std::size_t c = 0; c < second.channel.size(); ++c) {
      now_.total.push_back(second.channel[c].account);
      now_.seconds[c] += now_.total.back().state == TwinState::kPredicted;
    }
    if (options_.json) {
      nlohmann::ordered_json json{{"time_s", 1e-9 * static_cast<double>(second.time_ns)},
                                  {"speed_m_s", second.speed_m_s}};
      json.update(twin_json(now_));
      std::printf("%s\n", json.dump().c_str());
      std::fflush(stdout);
    } else {
      screen_.draw(twin_lines(now_), true);
    }
  }

  /// A drive that is played faster than it can be predicted waits: some seconds of four nodes at 10 kHz.
  static constexpr std::size_t kAhead = 64 << 20;

  const LiveTwinOptions& options_;
  Bus bus_;
  Screen screen_;
  InSequence sequence_{InSequence::From::kFirstHeard};
  std::int64_t missed_ = 0;
  RecordedTwin now_{};
  LiveTwin twin_;
  std::string reported_;
  std::unique_ptr<SealedBlock> block_ = std::make_unique<SealedBlock>();
};

/// Simulates the car beside the nodes on the bus and prints each second what of it is explained; with json an
/// object on a line of its own.
/// @return an ExitCode: whether any channel was predicted
/// @throws ConfigError if the vehicle has no twin
int show_live_twin(const LiveTwinOptions& options) {
  const StopOnSignal signals;
  Listener listener(options, VehicleConfig::read_file(options.vehicle));
  const WallTime begin = WallClock::now();
  const auto over = [&] {
    return options.seconds > 0.0 &&
           std::chrono::duration<double>(WallClock::now() - begin).count() > options.seconds;
  };
  while (!signals.token().stop_requested() && !over()) listener.listen();
  if (listener.told_any()) return kDone;
  std::fprintf(stderr, "rb twin: no channel was predicted: no drive on the bus, or too short\n");
  return kAnswerIsNo;
}

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
  if (!found.refusal.empty()) std::fprintf(stderr, "rb twin: %s\n", found.refusal.c_str());
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
