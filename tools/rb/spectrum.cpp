#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/config/validators.hpp"
#include "host/analyser/read_recording.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/defects.hpp"
#include "tools/rb/recorded_spectra.hpp"

namespace roadbalance {
namespace {

struct SpectrumOptions {
  std::string folder;
  std::string channel;
  double segment_s = 4.0;
  bool json = false;
};

nlohmann::ordered_json to_json(const NodeConfig& node, const std::string& channel,
                               const CrossSpectra& spectra) {
  nlohmann::ordered_json json{{"channel", channel},
                              {"node", node.name},
                              {"unit", "(m/s^2)^2/Hz"},
                              {"window", "hann"},
                              {"averages", spectra.averages()},
                              {"step_hz", spectra.step_hz()},
                              {"enbw_hz", spectra.enbw_hz()},
                              {"frequency_hz", nlohmann::ordered_json::array()},
                              {"density", nlohmann::ordered_json::array()}};
  if (spectra.averages() == 0) return json;
  json["density"] = spectra.density(0);
  for (int bin = 0; bin < spectra.bins(); ++bin) json["frequency_hz"].push_back(bin * spectra.step_hz());
  return json;
}

int spectrum(const SpectrumOptions& options) {
  const NodeConfig* node = nullptr;
  VehicleConfig vehicle;
  std::optional<JointSpectra> channel;
  const RecordingDefects defects = read_recording(
      options.folder,
      [&](const VehicleConfig& recorded) {
        vehicle = recorded;
        const ChannelPlace place = find_channel(vehicle, "--channel", options.channel);
        node = &vehicle.node[static_cast<std::size_t>(place.node)];
        channel.emplace(vehicle, std::vector{place},
                        JointSpectra::Settings{.segment = segment_samples(options.segment_s, node->rate_hz)});
      },
      [&](const SealedBlock& block) { channel->consume(block); });

  warn_of_defects("spectrum", options.folder, defects);
  const auto result = to_json(*node, options.channel, channel->spectra());
  if (options.json) {
    std::printf("%s\n", result.dump().c_str());
  } else {
    std::printf("# %s, %d averages, noise bandwidth %.3f Hz\n# Hz   (m/s^2)^2/Hz\n", options.channel.c_str(),
                result["averages"].get<int>(), result["enbw_hz"].get<double>());
    for (std::size_t bin = 0; bin < result["density"].size(); ++bin)
      std::printf("%8.3f %.6e\n", result["frequency_hz"][bin].get<double>(),
                  result["density"][bin].get<double>());
  }
  if (result["averages"] == 0) say_no_segment("spectrum", *channel);
  return result["averages"] == 0 ? kAnswerIsNo : kDone;
}

}  // namespace

void add_spectrum(CLI::App& app, int& code) {
  auto options = std::make_shared<SpectrumOptions>();
  CLI::App* command = app.add_subcommand("spectrum", "Power spectral density of one channel of a recording");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_option("--channel", options->channel, "name of the channel in vehicle.toml")->required();
  command
      ->add_option("--segment-s", options->segment_s,
                   "length of the averaged segments, s; resolves 1.5 / length")
      ->check(number_within(0.01, 1000.0))
      ->capture_default_str();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = spectrum(*options); });
}

}  // namespace roadbalance
