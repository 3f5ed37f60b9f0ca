#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "host/analyser/identify_record.hpp"
#include "host/identify/estimator.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/compensation_json.hpp"
#include "tools/rb/defects.hpp"
#include "tools/rb/identification_json.hpp"
#include "tools/rb/identify_with.hpp"
#include "tools/rb/overall_lines.hpp"
#include "tools/rb/readout.hpp"
#include "tools/study/wheels_json.hpp"

namespace roadbalance {
namespace {

struct IdentifyOptions {
  std::string folder;
  std::string estimator;
  bool json = false;
  bool refine = false;
  bool overall = false;
};

int identify(const IdentifyOptions& options) {
  if (!options.estimator.empty())
    return identify_with(options.estimator, options.folder, options.refine, options.json);
  const RecordedEstimate found = identify_record(options.folder, options.refine);
  const auto& [identification, balance] = found.estimate;
  warn_of_defects("identify", options.folder, found.defects);
  if (!found.obstacle.empty()) std::fprintf(stderr, "rb identify: %s\n", found.obstacle.c_str());
  if (options.overall && !found.overall)
    std::fprintf(stderr, "rb identify: no overall compensation: what turns with the wheels is not known\n");
  if (options.json) {
    nlohmann::ordered_json result{{"wheels", wheels_json(identification, balance)},
                                  {"suspension", suspension_json(identification)}};
    result.update(fit_json(identification));
    result["compensation"] = compensation_json(balance, found.compensation);
    result["remarks"] = found.remarks;
    if (options.overall)
      result["overall"] = found.overall ? overall_json(*found.overall) : nlohmann::ordered_json();
    std::printf("%s\n", result.dump().c_str());
  } else {
    std::printf("%s\n", identification_line(identification, found.obstacle).c_str());
    for (const std::string& line : suspension_lines(identification)) std::printf("  %s\n", line.c_str());
    for (std::size_t w = 0; w < kWheels; ++w) {
      std::printf("%s\n", balance_line(balance[w]).c_str());
      for (const std::string& line : advice_lines(balance[w], found.compensation[w]))
        std::printf("%s\n", line.c_str());
    }
    if (options.overall && found.overall)
      for (const std::string& line : overall_lines(*found.overall)) std::printf("%s\n", line.c_str());
    for (const std::string& remark : found.remarks) std::printf("  %s\n", remark.c_str());
  }
  const bool any =
      std::ranges::any_of(balance, [](const Balance& wheel) { return wheel.state == Unknown::kNone; });
  return any && (found.overall || !options.overall) ? kDone : kAnswerIsNo;
}

}  // namespace

void add_identify(CLI::App& app, int& code) {
  auto options = std::make_shared<IdentifyOptions>();
  CLI::App* command =
      app.add_subcommand("identify", "Finds tyre stiffness and unbalance of every wheel from a recording");
  command->add_option("folder", options->folder, "the recording")->required();
  std::string kinds;
  for (const EstimatorKind& kind : estimators()) kinds += "\n  " + kind.name + ": " + kind.what;
  command->add_option("--estimator", options->estimator,
                      "put the drive to one estimator instead of the product's chain:" + kinds);
  command
      ->add_flag(
          "--overall", options->overall,
          "also weights that make the vertical vibration at every [[seat]] of vehicle.toml least over all "
          "speeds driven, whatever turns with the wheels")
      ->excludes("--estimator");
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->add_flag(
      "--refine", options->refine,
      "compute the relations of the nodes' clocks and the wheels' angles again from all recorded "
      "exchanges and edges, which are in memory at once: up to 100 bytes an edge, 1.4 GB for an hour of "
      "four rings of 96 at 18 turns a second");
  command->callback([options, &code] { code = identify(*options); });
}

}  // namespace roadbalance
