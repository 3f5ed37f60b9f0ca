#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "host/analyser/before_drive.hpp"
#include "host/analyser/recorded_vehicle.hpp"
#include "host/receipts/receipt.hpp"
#include "tools/rb/alarm_lines.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/compensation_json.hpp"
#include "tools/rb/defects.hpp"
#include "tools/rb/report_html.hpp"
#include "tools/rb/verification_line.hpp"
#include "tools/study/wheels_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct ReportOptions {
  std::string folder, before, output;
  bool json = false;
};

DriveReport gather(const ReportOptions& options) {
  const Verification proof = verify_record(options.folder);
  DriveReport report{.vehicle = {},
                     .found = identify_record(options.folder),
                     .receipt = receipt_of(options.folder, proof),
                     .alarms = proof.alarms};
  report.vehicle = recorded_vehicle(options.folder).value();
  warn_of_defects("report", options.folder, report.found.defects);
  if (!options.before.empty())
    report.verification =
        verify_weights(evaluate_drive(options.before), {.name = report.receipt.name,
                                                        .vehicle = report.vehicle,
                                                        .balance = report.found.estimate.balance,
                                                        .compensation = report.found.compensation});
  return report;
}

/// What the page says, in the words of rb identify.
Json json_of(const DriveReport& report) {
  const auto& [identification, balance] = report.found.estimate;
  Json verification = nullptr, nodes = Json::array();
  if (report.verification) {
    verification = Json::array();
    for (const WheelVerification& wheel : *report.verification)
      verification.push_back(wheel_verification_json(wheel));
  }
  for (const auto& node : report.receipt.node)
    nodes.push_back({{"node", node.node},
                     {"samples", node.samples},
                     {"samples_lost", node.samples_lost},
                     {"repaired", node.repaired},
                     {"seconds", node.seconds},
                     {"overload_s", node.overload_s},
                     {"clock_known_to_s", node.sync_residual_s < 0.0 ? Json() : Json(node.sync_residual_s)}});
  return {{"vehicle", report.vehicle.name},
          {"recording", report.receipt.name},
          {"wheels", wheels_json(identification, balance)},
          {"compensation", compensation_json(balance, report.found.compensation)},
          {"verification", verification},
          {"remarks", report.found.remarks},
          {"verdict", report.receipt.verdict},
          {"refused", report.receipt.refused},
          {"nodes", nodes},
          {"alarms", recorded_alarms_json(report.alarms.all())},
          {"alarms_left_out", report.alarms.left_out()}};
}

int report(const ReportOptions& options) {
  const DriveReport found = gather(options);
  std::ofstream file(options.output, std::ios::binary);
  file << report_html(found);
  file.close();
  if (!file) throw std::runtime_error(options.output + ": cannot be written");
  if (options.json) std::printf("%s\n", json_of(found).dump().c_str());
  const bool any = std::ranges::any_of(found.found.estimate.balance,
                                       [](const Balance& wheel) { return wheel.state == Unknown::kNone; });
  if (!any) std::fprintf(stderr, "rb report: no wheel is known; the report says why\n");
  return any ? kDone : kAnswerIsNo;
}

}  // namespace

void add_report(CLI::App& app, int& code) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* command = app.add_subcommand(
      "report",
      "A page to print: the balance of a drive, before and after weights, and proof of completeness");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_option("--before", options->before, "recording of the drive before the weights were fitted");
  command->add_option("-o,--output", options->output, "HTML file to write")->required();
  command->add_flag("--json", options->json, "the same as one JSON object on standard output, too");
  command->callback([options, &code] { code = report(*options); });
}

}  // namespace roadbalance
