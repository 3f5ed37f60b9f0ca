#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "common/config/validators.hpp"
#include "common/dsp/transfer_function.hpp"
#include "host/recording/read_recording.hpp"
#include "tools/rb/command.hpp"
#include "tools/views/recorded_spectra.hpp"
#include "tools/views/recording_defects.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct ResponseOptions {
  std::string folder, input, output;
  double segment_s = 2.0;
  double overlap_percent = 50.0;
  std::string window = "hann";
  bool json = false;
};

double degrees_of(std::complex<double> h) {
  return std::arg(h) * 180.0 / std::numbers::pi;
}

Json bin_json(const TransferFunction& h, std::size_t k) {
  // JSON has no infinity.
  const Json radius = std::isfinite(h.radius_95[k]) ? Json(h.radius_95[k]) : Json(nullptr);
  return {{"h1", {h.h1[k].real(), h.h1[k].imag()}},  {"h2", {h.h2[k].real(), h.h2[k].imag()}},
          {"hv", {h.hv[k].real(), h.hv[k].imag()}},  {"coherence", h.coherence[k]},
          {"coherence_sigma", h.coherence_sigma[k]}, {"radius_95", radius}};
}

Json response_json(const ResponseOptions& options, const CrossSpectra& spectra, const TransferFunction& h) {
  const auto delay = mean_delay_s(h, spectra.step_hz());
  Json json{{"input", options.input},
            {"output", options.output},
            {"window", options.window},
            {"overlap_percent", options.overlap_percent},
            {"averages", spectra.averages()},
            {"independent_averages", spectra.independent_averages()},
            {"step_hz", spectra.step_hz()},
            {"enbw_hz", spectra.enbw_hz()},
            {"coherence_by_chance", h.coherence_by_chance},
            {"mean_delay_s", delay ? Json(*delay) : Json()},
            {"bins", Json::array()}};
  for (std::size_t k = 0; k < h.h1.size(); ++k) {
    Json bin{{"frequency_hz", static_cast<double>(k) * spectra.step_hz()}};
    bin.update(bin_json(h, k));
    json["bins"].push_back(bin);
  }
  return json;
}

void print(const ResponseOptions& options, const CrossSpectra& spectra, const TransferFunction& h) {
  std::printf(
      "# %s / %s, %d averages (%.1f independent), noise bandwidth %.3f Hz\n"
      "# coherence of unrelated channels: below %.3f in 95 of 100 bins; +- is 95 %%\n"
      "#     Hz       |H1|         +-   phase deg       |H2|       |Hv|  coherence\n",
      options.output.c_str(), options.input.c_str(), spectra.averages(), spectra.independent_averages(),
      spectra.enbw_hz(), h.coherence_by_chance);
  if (const auto delay = mean_delay_s(h, spectra.step_hz()))
    std::printf("# mean delay of the output: %.3f ms\n", 1e3 * *delay);
  for (std::size_t k = 0; k < h.h1.size(); ++k)
    std::printf("%8.3f %10.4g %10.2g %11.2f %10.4g %10.4g %10.4f\n",
                static_cast<double>(k) * spectra.step_hz(), std::abs(h.h1[k]), h.radius_95[k],
                degrees_of(h.h1[k]), std::abs(h.h2[k]), std::abs(h.hv[k]), h.coherence[k]);
}

int response(const ResponseOptions& options) {
  std::optional<JointSpectra> joint;
  const RecordingDefects defects = read_recording(
      options.folder,
      [&](const VehicleConfig& vehicle) {
        const ChannelPlace input = find_channel(vehicle, "--input", options.input);
        const ChannelPlace output = find_channel(vehicle, "--output", options.output);
        const double rate_hz = vehicle.node[static_cast<std::size_t>(input.node)].rate_hz;
        joint.emplace(vehicle, std::vector{input, output},
                      JointSpectra::Settings{.segment = segment_samples(options.segment_s, rate_hz),
                                             .overlap = options.overlap_percent / 100.0,
                                             .window = windows_by_name().at(options.window)});
      },
      [&](const SealedBlock& block) { joint->consume(block); },
      [&](const ClockFit& fit) { joint->consume(fit); });
  warn_of_defects("response", options.folder, defects);
  const CrossSpectra& spectra = joint->spectra();
  if (spectra.averages() == 0) {
    say_no_segment("response", *joint);
    return kAnswerIsNo;
  }
  const TransferFunction h = transfer_function(spectra.density(0), spectra.density(1), spectra.density(0, 1),
                                               spectra.independent_averages());
  if (options.json)
    std::printf("%s\n", response_json(options, spectra, h).dump().c_str());
  else
    print(options, spectra, h);
  return kDone;
}

}  // namespace

void add_response(CLI::App& app, int& code) {
  auto options = std::make_shared<ResponseOptions>();
  CLI::App* command = app.add_subcommand(
      "response", "Transfer function and coherence of two channels of a recording, of one node or of two");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_option("--input", options->input, "name of a channel in vehicle.toml")->required();
  command->add_option("--output", options->output, "name of a channel in vehicle.toml")->required();
  command->add_option("--segment-s", options->segment_s, "length of the averaged segments, s")
      ->check(number_within(0.01, 1000.0))
      ->capture_default_str();
  command->add_option("--overlap", options->overlap_percent, "of the segments, %")
      ->check(number_within(0.0, 75.0))
      ->capture_default_str();
  command->add_option("--window", options->window, "hann, flat-top or rectangular")
      ->check(CLI::IsMember(windows_by_name()))
      ->capture_default_str();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = response(*options); });
}

}  // namespace roadbalance
