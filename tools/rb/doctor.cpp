#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/config/validators.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/machine.hpp"

namespace roadbalance {
namespace {

struct DoctorOptions {
  std::string folder = "recordings";
  double seconds = 2.0;
  bool json = false;
};

int examine(const DoctorOptions& options) {
  const std::vector<Finding> findings = examine_machine(
      options.folder, std::chrono::milliseconds(static_cast<std::int64_t>(1000.0 * options.seconds)));
  bool well = true;
  auto list = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    well = well && finding.state != Finding::kIll;
    if (options.json) {
      list.push_back({{"name", finding.name},
                      {"ok", finding.state == Finding::kWell},
                      {"needed", finding.state == Finding::kIll},
                      {"finding", finding.sentence},
                      {"remedy", finding.remedy.empty() ? nullptr : nlohmann::ordered_json(finding.remedy)}});
      continue;
    }
    static constexpr const char* kMark[] = {"ok    ", "note  ", "ill   "};
    std::printf("%s %s\n", kMark[finding.state], finding.sentence.c_str());
    if (!finding.remedy.empty()) std::printf("        mend it with: %s\n", finding.remedy.c_str());
  }
  if (options.json)
    std::printf("%s\n", nlohmann::ordered_json{{"ok", well}, {"findings", list}}.dump().c_str());
  return well ? kDone : kAnswerIsNo;
}

}  // namespace

void add_doctor(CLI::App& app, int& code) {
  auto options = std::make_shared<DoctorOptions>();
  CLI::App* command =
      app.add_subcommand("doctor", "Says what this machine lacks, and the command that mends it");
  command->add_option("--folder", options->folder, "where recordings will be written")->capture_default_str();
  command
      ->add_option("--seconds", options->seconds,
                   "how long the wake-ups of threads are measured; load the machine meanwhile as it will be")
      ->check(number_within(0.1, 86'400.0))
      ->capture_default_str();
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->callback([options, &code] { code = examine(*options); });
}

}  // namespace roadbalance
