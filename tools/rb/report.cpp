#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "common/config/section.hpp"
#include "common/record/file.hpp"
#include "host/analysis/drives/before_drive.hpp"
#include "host/recording/recorded_vehicle.hpp"
#include "host/recordings/recording_summary.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/reading_progress.hpp"
#include "tools/report/report_html.hpp"
#include "tools/views/alarm_lines.hpp"
#include "tools/views/compensation_json.hpp"
#include "tools/views/recording_defects.hpp"
#include "tools/views/weight_check_line.hpp"
#include "tools/views/wheels_json.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct ReportOptions {
  std::string folder, before, output;
  bool complete = false, json = false;
};

/// Nothing is known of any wheel.
RecordedEstimate nothing_found() {
  RecordedEstimate found;
  for (std::size_t w = 0; w < kWheels; ++w)
    found.estimate.balance[w].wheel = found.compensation[w].wheel = static_cast<std::int32_t>(w);
  return found;
}

/// A recording that gives no unbalance has a report all the same, which names the reason.
void identify(const ReportOptions& options, DriveReport& report) {
  try {
    report.found = identify_record(options.folder);
    warn_of_defects("report", options.folder, report.found.defects);
  } catch (const std::exception& error) {
    report.failure = error.what();
  }
}

std::optional<VehicleConfig> vehicle_of(const std::string& folder) {
  try {
    return recorded_vehicle(folder);
  } catch (const std::exception&) {
    return std::nullopt;  // identify_record() reports why
  }
}

DriveReport gather(const ReportOptions& options, const std::optional<VehicleConfig>& vehicle) {
  const Verification proof = verify_record(options.folder);
  if (proof.verdict == Verdict::kUnreadable) throw std::runtime_error(proof.error);
  DriveReport report{.vehicle = vehicle.value_or(VehicleConfig{}),
                     .vehicle_known = vehicle.has_value(),
                     .found = nothing_found(),
                     .receipt = summary_of(options.folder, proof),
                     .alarms = proof.alarms};
  if (!vehicle) report.vehicle.name = "a vehicle that is not known";
  identify(options, report);
  if (!options.before.empty() && report.failure.empty())
    report.weight_check =
        check_weights(evaluate_drive(options.before), {.name = report.receipt.name,
                                                       .vehicle = report.vehicle,
                                                       .balance = report.found.estimate.balance,
                                                       .compensation = report.found.compensation});
  if (options.complete) report.account = account_of(options.folder, vehicle, proof);
  return report;
}

/// The contents of the page, in the words of rb identify.
Json json_of(const DriveReport& report) {
  const auto& [identification, balance] = report.found.estimate;
  Json weight_check = nullptr, nodes = Json::array();
  if (report.weight_check) {
    weight_check = Json::array();
    for (const WeightCheck& wheel : *report.weight_check) weight_check.push_back(weight_check_json(wheel));
  }
  for (const auto& node : report.receipt.node)
    nodes.push_back({{"node", node.node},
                     {"samples", node.samples},
                     {"samples_lost", node.samples_lost},
                     {"absent", node.absent},
                     {"repaired", node.repaired},
                     {"seconds", node.seconds},
                     {"overload_s", node.overload_s},
                     {"clock_known_to_s", node.sync_residual_s < 0.0 ? Json() : Json(node.sync_residual_s)}});
  return {{"vehicle", report.vehicle.name},
          {"recording", report.receipt.name},
          {"wheels", wheels_json(identification, balance)},
          {"compensation", compensation_json(balance, report.found.compensation)},
          {"verification", weight_check},
          {"remarks", report.found.diagnostics},
          {"verdict", report.receipt.verdict},
          {"refused", report.receipt.refused},
          {"nodes", nodes},
          {"failure", report.failure.empty() ? Json() : Json(report.failure)},
          {"alarms", recorded_alarms_json(report.alarms.all())},
          {"alarms_left_out", report.alarms.left_out()}};
}

/// A device or a link, /dev/stdout is one, would be replaced as a file is.
void expect_replaceable(const std::filesystem::path& file) {
  const auto there = std::filesystem::symlink_status(file);
  if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there))
    throw ConfigError("--output " + file.string() +
                      ": is there and no file; allowed: a new file, or one to replace");
}

int report(const ReportOptions& options) {
  expect_replaceable(options.output);
  const std::optional<VehicleConfig> vehicle = vehicle_of(options.folder);
  const DriveReport found = [&] {
    const ReadingProgress progress(options.folder, options.complete ? 5 : 3);
    return gather(options, vehicle);
  }();
  write_atomically(options.output, report_html(found));
  if (options.json) std::printf("%s\n", json_of(found).dump().c_str());
  if (!found.failure.empty()) std::fprintf(stderr, "rb report: %s\n", found.failure.c_str());
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
      "A page to print: the balance of a drive, before and after weights, and proof of completeness; with "
      "--complete the whole account of the drive behind it");
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_option("--before", options->before, "recording of the drive before the weights were fitted");
  command->add_option("-o,--output", options->output, "HTML file to write")->required();
  command->add_flag(
      "--complete", options->complete,
      "behind the page the account of the drive: vehicle, sensors and calibration, conditions, "
      "levels, a spectrum of every channel, orders, identification with its uncertainty, weights, "
      "alarms, every gap; prints to A4, eight pages for two nodes of twelve channels");
  command->add_flag("--json", options->json,
                    "what the first page says as one JSON object on standard output, too");
  command->footer(
      "A PDF is what a browser prints of the file, or without a window\n"
      "  chromium --headless --no-pdf-header-footer --print-to-pdf=FILE.pdf FILE.html\n"
      "Exit codes: 0 done, 1 no wheel is known, and the report says why, 2 usage, 4 cannot read or "
      "write.");
  command->callback([options, &code] { code = report(*options); });
}

}  // namespace roadbalance
