#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/config/validators.hpp"
#include "host/recording/read_recording.hpp"
#include "tools/rb/command.hpp"
#include "tools/views/recording_defects.hpp"
#include "tools/views/recorded_spectra.hpp"

namespace roadbalance {
namespace {

struct SpectrumOptions {
  std::string folder;
  std::string channel;
  double segment_s = kSegment_s;
  std::optional<int> block;  ///< samples, in place of segment_s
  double overlap_percent = 50.0;
  std::string window = "hann";
  std::string average = "linear";
  int memory = 8;
  std::string show = "density";
  bool json = false;
};

/// A line of density G is as strong as a sine of rms sqrt(G B), B the equivalent noise bandwidth; at 0 Hz and
/// at half the rate there is no sine, and its peak is its rms.
std::vector<double> shown(std::vector<double> density, const SpectrumOptions& options,
                          const CrossSpectra& spectra, int segment) {
  if (options.show == "density") return density;
  for (std::size_t k = 0; k < density.size(); ++k) {
    const bool is_sine = k > 0 && 2 * k != static_cast<std::size_t>(segment);
    density[k] = std::sqrt(density[k] * spectra.enbw_hz() * (options.show == "peak" && is_sine ? 2.0 : 1.0));
  }
  return density;
}

std::string unit_of(const std::string& what, ChannelRole role) {
  const std::string unit = role == ChannelRole::kRoad ? "m" : "m/s^2";
  if (what != "density") return unit + " " + what;
  return role == ChannelRole::kRoad ? "m^2/Hz" : "(m/s^2)^2/Hz";
}

JointSpectra::Settings settings_of(const SpectrumOptions& options, double rate_hz) {
  return {.segment = options.block ? *options.block : segment_samples(options.segment_s, rate_hz),
          .overlap = options.overlap_percent / 100.0,
          .window = windows_by_name().at(options.window),
          .memory = options.average == "exponential" ? options.memory : 0,
          .hold_peaks = options.average == "peak-hold"};
}

nlohmann::ordered_json to_json(const NodeConfig& node, const ChannelConfig& channel,
                               const SpectrumOptions& options, const CrossSpectra& spectra) {
  nlohmann::ordered_json json{
      {"channel", options.channel},
      {"node", node.name},
      {"unit", unit_of(options.show, channel.role)},
      {"window", options.window},
      {"overlap_percent", options.overlap_percent},
      {"average", options.average},
      {"memory", options.average == "exponential" ? options.memory : 0},
      {"averages", spectra.averages()},
      {"step_hz", spectra.step_hz()},
      {"enbw_hz", spectra.enbw_hz()},
      {"frequency_hz", nlohmann::ordered_json::array()},
      {options.show == "density" ? "density" : "amplitude", nlohmann::ordered_json::array()}};
  if (spectra.averages() == 0) return json;
  json.back() = shown(options.average == "peak-hold" ? spectra.peak_density(0) : spectra.density(0), options,
                      spectra, settings_of(options, node.rate_hz).segment);
  for (int bin = 0; bin < spectra.bins(); ++bin) json["frequency_hz"].push_back(bin * spectra.step_hz());
  return json;
}

int spectrum(const SpectrumOptions& options) {
  const NodeConfig* node = nullptr;
  const ChannelConfig* config = nullptr;
  VehicleConfig vehicle;
  std::optional<JointSpectra> channel;
  const RecordingDefects defects = read_recording(
      options.folder,
      [&](const VehicleConfig& recorded) {
        vehicle = recorded;
        const ChannelPlace place = find_channel(vehicle, "--channel", options.channel);
        node = &vehicle.node[static_cast<std::size_t>(place.node)];
        config = &node->channel[static_cast<std::size_t>(place.channel)];
        channel.emplace(vehicle, std::vector{place}, settings_of(options, node->rate_hz));
      },
      [&](const SealedBlock& block) { channel->consume(block); });

  warn_of_defects("spectrum", options.folder, defects);
  const auto result = to_json(*node, *config, options, channel->spectra());
  if (options.json) {
    std::printf("%s\n", result.dump().c_str());
  } else {
    std::printf(
        "# %s, %s window, %g %% overlap, %s average of %d, noise bandwidth %.3f Hz\n# Hz   %s, one-sided\n",
        options.channel.c_str(), options.window.c_str(), options.overlap_percent, options.average.c_str(),
        result["averages"].get<int>(), result["enbw_hz"].get<double>(),
        result["unit"].get<std::string>().c_str());
    const auto& values = result.back();
    for (std::size_t bin = 0; bin < values.size(); ++bin)
      std::printf("%8.3f %.6e\n", result["frequency_hz"][bin].get<double>(), values[bin].get<double>());
  }
  if (result["averages"] == 0) say_no_segment("spectrum", *channel);
  return result["averages"] == 0 ? kAnswerIsNo : kDone;
}

}  // namespace

void add_spectrum(CLI::App& app, int& code) {
  auto options = std::make_shared<SpectrumOptions>();
  CLI::App* command =
      app.add_subcommand("spectrum", "Spectrum of one channel of a recording: density or amplitude");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_option("--channel", options->channel, "name of the channel in vehicle.toml")->required();
  CLI::Option* const segment = command
                                   ->add_option("--segment-s", options->segment_s,
                                                "length of the averaged segments, s; resolves 1.5 / length")
                                   ->check(number_within(0.01, 1000.0))
                                   ->capture_default_str();
  command->add_option("--block", options->block, "samples of a segment, in place of --segment-s")
      ->check(CLI::Range(64, 1 << 20))
      ->excludes(segment);
  command->add_option("--overlap", options->overlap_percent, "of the segments, %")
      ->check(number_within(0.0, 75.0))
      ->capture_default_str();
  command->add_option("--window", options->window, "hann, flat-top (for amplitudes) or rectangular")
      ->check(CLI::IsMember(windows_by_name()))
      ->capture_default_str();
  command->add_option("--average", options->average, "linear, exponential or peak-hold")
      ->check(CLI::IsMember({"linear", "exponential", "peak-hold"}))
      ->capture_default_str();
  command->add_option("--memory", options->memory, "segments that the exponential average remembers")
      ->check(CLI::Range(1, 10'000))
      ->capture_default_str();
  command->add_option("--show", options->show, "density, or the amplitude of a line: peak or rms")
      ->check(CLI::IsMember({"density", "peak", "rms"}))
      ->capture_default_str();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = spectrum(*options); });
}

}  // namespace roadbalance
