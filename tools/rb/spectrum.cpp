#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/codec.hpp"
#include "common/config/section.hpp"
#include "common/config/validators.hpp"
#include "common/dsp/psd.hpp"
#include "host/analyser/read_recording.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/defects.hpp"

namespace roadbalance {
namespace {

struct SpectrumOptions {
  std::string folder;
  std::string channel;
  double segment_s = 4.0;
  bool json = false;
};

struct Place {
  const NodeConfig* node;
  std::size_t channel;
};

/// @throws ConfigError listing the channels there are
Place find_channel(const VehicleConfig& vehicle, const std::string& name) {
  std::string there;
  for (const auto& node : vehicle.node)
    for (std::size_t c = 0; c < node.channel.size(); ++c) {
      if (node.channel[c].name == name) return {&node, c};
      there += " " + node.channel[c].name;
    }
  throw ConfigError("--channel " + name + ": the recording has no such channel; allowed:" + there);
}

/// Averages over all that was recorded without a hole for at least one segment.
class ChannelSpectrum {
 public:
  ChannelSpectrum(const Place& place, double segment_s)
      : place_(place),
        psd_({.rate_hz = place.node->rate_hz,
              .segment = std::max(2, static_cast<int>(std::lround(segment_s * place.node->rate_hz)))}),
        sum_(static_cast<std::size_t>(psd_.bins())) {}

  void add(const SealedBlock& sealed) {
    if (sealed.kind != BlockKind::kScan || sealed.header.node != place_.node->id) return;
    const ScanBlock block = decode_scan(sealed);
    if (block.header.epoch != epoch_ || block.header.first_scan != next_scan_) end_run();
    epoch_ = block.header.epoch;
    next_scan_ = block.header.first_scan + block.header.scans;
    for (std::int64_t row = 0; row < block.header.scans; ++row) {
      const std::int32_t counts = block.counts[static_cast<std::size_t>(row)][place_.channel];
      const double sample = place_.node->channel[place_.channel].to_si(counts);
      psd_.add({&sample, 1});
    }
  }

  nlohmann::ordered_json result() {
    end_run();
    nlohmann::ordered_json json{{"channel", place_.node->channel[place_.channel].name},
                                {"node", place_.node->name},
                                {"unit", "(m/s^2)^2/Hz"},
                                {"window", "hann"},
                                {"averages", averages_},
                                {"step_hz", psd_.step_hz()},
                                {"enbw_hz", psd_.enbw_hz()},
                                {"frequency_hz", nlohmann::ordered_json::array()},
                                {"density", nlohmann::ordered_json::array()}};
    for (std::size_t bin = 0; averages_ > 0 && bin < sum_.size(); ++bin) {
      json["frequency_hz"].push_back(static_cast<double>(bin) * psd_.step_hz());
      json["density"].push_back(sum_[bin] / averages_);
    }
    return json;
  }

 private:
  /// A hole is not a signal: what was averaged before it is kept, the segment it cuts is dropped.
  void end_run() {
    const std::vector<double> density = psd_.density();
    for (std::size_t bin = 0; bin < sum_.size(); ++bin) sum_[bin] += density[bin] * psd_.averages();
    averages_ += psd_.averages();
    psd_.reset();
  }

  Place place_;
  WelchPsd psd_;
  std::vector<double> sum_;
  int averages_ = 0;
  std::int64_t epoch_ = 0;
  std::int64_t next_scan_ = 0;
};

int spectrum(const SpectrumOptions& options) {
  VehicleConfig vehicle;
  std::optional<ChannelSpectrum> channel;
  const RecordingDefects defects = read_recording(
      options.folder,
      [&](const VehicleConfig& recorded) {
        vehicle = recorded;
        channel.emplace(find_channel(vehicle, options.channel), options.segment_s);
      },
      [&](const SealedBlock& block) { channel->add(block); });

  warn_of_defects("spectrum", options.folder, defects);
  const auto result = channel->result();
  if (options.json) {
    std::printf("%s\n", result.dump().c_str());
  } else {
    std::printf("# %s, %d averages, noise bandwidth %.3f Hz\n# Hz   (m/s^2)^2/Hz\n", options.channel.c_str(),
                result["averages"].get<int>(), result["enbw_hz"].get<double>());
    for (std::size_t bin = 0; bin < result["density"].size(); ++bin)
      std::printf("%8.3f %.6e\n", result["frequency_hz"][bin].get<double>(),
                  result["density"][bin].get<double>());
  }
  if (result["averages"] == 0)
    std::fprintf(stderr, "rb spectrum: no stretch without a hole is as long as a segment\n");
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
