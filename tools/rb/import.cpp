#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/recording/formats/hdf5_reader.hpp"
#include "host/recording/formats/uff58_reader.hpp"
#include "host/recording/formats/wav_reader.hpp"
#include "tools/import/candump_samples.hpp"
#include "tools/import/import_samples.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/progress_line.hpp"

namespace roadbalance {
namespace {

struct ImportOptions {
  std::string samples;
  std::string pulses;
  std::vector<std::string> tachometer;
  std::string marks;
  std::string vehicle;
  std::string folder;
  std::string dbc;
  OpenSamples open = open_csv_samples;
  UnitOptions units;
  bool json = false;
};

struct Format {
  const char *name, *about, *samples;
  std::unique_ptr<SampleSource> (*open)(const std::filesystem::path& file);
};
constexpr std::array kFormats{
    Format{"csv", "Samples and pulses as comma-separated values",
           "first row names, second row units, first column time_s; an empty cell is no sample",
           open_csv_samples},
    Format{
        "hdf5", "Samples of an HDF5 file, pulses as comma-separated values",
        "one group with time_s and a data set for each channel, attributes units, scale_factor, add_offset, "
        "_FillValue",
        open_hdf5_samples},
    Format{"uff58", "Samples of an ASCII universal file, pulses as comma-separated values",
           "time responses (58) of one even abscissa; the first ID line names the channel, record 9 its unit",
           open_uff58_samples},
    Format{"wav", "Samples of a WAV file of rb export, pulses as comma-separated values",
           "32-bit PCM whose comment tells channels and scales", open_wav_samples}};

nlohmann::ordered_json report_json(const ImportReport& report) {
  nlohmann::ordered_json json{{"sha256", report.sha256},
                              {"rows", report.rows},
                              {"seconds", report.seconds},
                              {"rate_hz", report.rate_hz},
                              {"stamp_rms_s", report.stamp_rms_s},
                              {"stamp_max_s", report.stamp_max_s},
                              {"has_pulses", report.has_pulses},
                              {"marks", report.marks},
                              {"channels", nlohmann::ordered_json::array()},
                              {"holes", nlohmann::ordered_json::array()},
                              {"suspicions", nlohmann::ordered_json::array()},
                              {"tachometers", nlohmann::ordered_json::array()},
                              {"nodes", nlohmann::ordered_json::array()}};
  for (const auto& channel : report.channels)
    if (!channel.meaning.empty())
      json["channels"].push_back({{"name", channel.channel},
                                  {"unit", channel.in_file},
                                  {"factor", channel.factor},
                                  {"understood", channel.meaning}});
  for (const auto& hole : report.holes)
    json["holes"].push_back({{"after_s", hole.after_s}, {"samples", hole.samples}});
  for (const auto& suspicion : report.suspicions)
    json["suspicions"].push_back({{"channel", suspicion.channel}, {"what", suspicion.what}});
  for (const auto& tachometer : report.tachometers)
    json["tachometers"].push_back({{"channel", tachometer.channel},
                                   {"wheel", kWheelNames[static_cast<std::size_t>(tachometer.wheel)]},
                                   {"pulses", tachometer.pulses},
                                   {"threshold", tachometer.threshold},
                                   {"stamp_sigma_s", tachometer.stamp_sigma_s}});
  for (const auto& node : report.nodes)
    json["nodes"].push_back({{"name", node.name},
                             {"blocks", node.blocks},
                             {"samples_recorded", node.scans},
                             {"samples_missing", node.scans_missing},
                             {"edges", node.edges}});
  return json;
}

/// For people, on standard error, so that nothing doubtful is hidden from those who take the JSON.
void tell(const ImportReport& report) {
  for (const auto& channel : report.channels)
    if (!channel.meaning.empty())
      std::fprintf(stderr, "channel %s%s: %s\n", channel.channel.c_str(),
                   channel.in_file.empty() ? "" : (" in \"" + channel.in_file + "\"").c_str(),
                   channel.meaning.c_str());
  std::fprintf(
      stderr, "%lld rows, %.1f s at %.3f Hz; stamps lie %.3g ms rms and %.3g ms at most from an even clock\n",
      static_cast<long long>(report.rows), report.seconds, report.rate_hz, report.stamp_rms_s * 1e3,
      report.stamp_max_s * 1e3);
  for (const auto& hole : report.holes)
    std::fprintf(stderr, "hole after %.3f s: %lld samples, declared as a gap\n", hole.after_s,
                 static_cast<long long>(hole.samples));
  for (const auto& suspicion : report.suspicions)
    std::fprintf(stderr, "suspicious: %s %s\n", suspicion.channel.c_str(), suspicion.what.c_str());
  for (const auto& tachometer : report.tachometers)
    std::fprintf(stderr, "tachometer %s of %s: %lld pulses through %.6g, each known to %.3g ms (sigma)\n",
                 tachometer.channel.c_str(), kWheelNames[static_cast<std::size_t>(tachometer.wheel)],
                 static_cast<long long>(tachometer.pulses), tachometer.threshold,
                 tachometer.stamp_sigma_s * 1e3);
  for (const auto& node : report.nodes)
    std::fprintf(stderr, "node %s: %lld samples recorded, %lld missing, %lld edges\n", node.name.c_str(),
                 static_cast<long long>(node.scans), static_cast<long long>(node.scans_missing),
                 static_cast<long long>(node.edges));
  if (!report.has_pulses)
    std::fprintf(stderr, "without pulses the wheels have no angle: unbalance cannot be identified\n");
}

int import(const ImportOptions& options) {
  const StopOnSignal signals;
  SampleImport request{
      .samples = options.samples, .folder = options.folder, .open = options.open, .units = options.units};
  if (!options.pulses.empty()) request.pulses = options.pulses;
  for (const std::string& text : options.tachometer) {
    const TachometerColumn tachometer = TachometerColumn::parse(text);
    if (std::ranges::find(request.tachometer, tachometer.wheel, &TachometerColumn::wheel) !=
        request.tachometer.end())
      throw ConfigError("--tachometer: " + text + ": its wheel has one already; allowed: one for each wheel");
    request.tachometer.push_back(tachometer);
  }
  if (!options.marks.empty()) request.marks = options.marks;
  const ImportReport report = [&] {
    const VehicleConfig vehicle = VehicleConfig::read_file(options.vehicle);
    std::error_code nobody_asked;  // the program that opens the file reports what is wrong with it
    const std::uintmax_t bytes = std::filesystem::file_size(options.samples, nobody_asked);
    ProgressLine line;
    return import_samples(request, vehicle, signals.token(), [&](double part) {
      line.show(part,
                static_cast<std::uint64_t>(2.0 * part * static_cast<double>(bytes)));  // it is read twice
    });
  }();
  tell(report);
  if (options.json) std::printf("%s\n", report_json(report).dump().c_str());
  const bool complete = std::all_of(report.nodes.begin(), report.nodes.end(),
                                    [](const auto& node) { return node.scans_missing == 0; });
  return complete ? kDone : kIncomplete;
}

CLI::App* add_format(CLI::App& command, const char* name, const char* about, const char* samples,
                     const std::shared_ptr<ImportOptions>& options, int& code) {
  CLI::App* one = command.add_subcommand(name, about);
  one->add_option("--samples", options->samples, samples)->required();
  CLI::Option* const pulses =
      one->add_option("--pulses", options->pulses, "time_s,wheel,kind with kind tooth or zero");
  one->add_option("--tachometer", options->tachometer,
                  "COLUMN=WHEEL: the column's signal gives the pulses of the wheel's encoder, one where it "
                  "rises through the middle; for each wheel")
      ->excludes(pulses);
  one->add_option("--marks", options->marks, "time_s,number,text as rb export --marks writes them");
  one->add_option("--units", options->units.units,
                  "unit of all channels or of one, whatever the file says: g, or CHANNEL=mm/s^2");
  one->add_option("--sensitivity", options->units.sensitivity,
                  "of channels in volts, of all or of one: 100mV/g, or CHANNEL=10.2mV/(m/s^2)");
  one->add_option("--vehicle", options->vehicle, "vehicle.toml that gives each channel a place")->required();
  one->add_option("-o,--output", options->folder, "folder of the recording to make")->required();
  one->add_flag("--json", options->json, "one JSON object on standard output");
  one->callback([options, &code] { code = import(*options); });
  return one;
}

}  // namespace

void add_import(CLI::App& app, int& code) {
  CLI::App* command = app.add_subcommand("import", "Makes a recording from somebody else's data");
  command->require_subcommand(1);
  command->footer(
      "Exit codes: 0 done, 3 samples are missing in the recording as they were in the file, and declared, 2 "
      "usage, "
      "or what is in the file cannot be used, 4 cannot read or write.");
  for (const Format& format : kFormats) {
    auto options = std::make_shared<ImportOptions>();
    options->open = format.open;
    add_format(*command, format.name, format.about, format.samples, options, code);
  }
  auto options = std::make_shared<ImportOptions>();
  options->open = [options = options.get()](const std::filesystem::path& log) {
    return open_candump_samples(log, options->dbc);
  };
  add_format(*command, "candump", "Samples of a log of candump -L, pulses as comma-separated values",
             "log of one bus; frames of one stamp are of one instant", options, code)
      ->add_option("--dbc", options->dbc, "DBC file whose signals are the channels")
      ->required();
}

}  // namespace roadbalance
