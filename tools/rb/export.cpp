#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/recording/formats/description_json.hpp"
#include "host/recording/formats/export_recording.hpp"
#include "tools/rb/command.hpp"
#include "tools/rb/progress_line.hpp"
#include "tools/views/recording_defects.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

struct ExportOptions {
  ExportRequest request;
  std::string folder, file, vehicle, pulses, marks, dbc;
  double to_s = 0.0;
  bool has_to = false;
  bool json = false;
};

/// The contents of the file, as the file describes them, and how the export went.
Json report_json(const ExportOptions& options, const ExportReport& report) {
  Json json = description_of(report.table);
  json.update({{"file", options.file},
               {"format", options.request.format},
               {"bytes", report.bytes},
               {"rows", report.rows},
               {"rows_missing", report.missing},
               {"pulses", report.pulses.written},
               {"pulses_left_out", report.pulses.left_out},
               {"marks_left_out", report.marks_left_out},
               {"damaged_bytes", report.defects.damaged_bytes},
               {"blocks_refused", report.defects.refused_blocks},
               {"blocks_missing", report.defects.missing_blocks}});
  return json;
}

void tell(const ExportOptions& options, const ExportReport& report) {
  for (const auto& group : report.table.group)
    std::fprintf(stderr, "%s: %lld rows of %zu channels, %.6g Hz\n", group.name.c_str(),
                 static_cast<long long>(group.rows), group.channel.size(), group.rate_hz);
  if (report.missing > 0)
    std::fprintf(stderr, "in %lld of them samples of a node are missing, and marked so\n",
                 static_cast<long long>(report.missing));
  for (const auto& part : report.table.left_out)
    std::fprintf(stderr, "node %s: its clock is not known, %lld samples left out\n", part.node.c_str(),
                 static_cast<long long>(part.samples));
  if (report.pulses.left_out > 0)
    std::fprintf(stderr, "%lld pulses left out: the clock of their node is not known\n",
                 static_cast<long long>(report.pulses.left_out));
  if (report.marks_left_out > 0)
    std::fprintf(stderr, "%lld marks left out: no more than the first %zu of a recording are exported\n",
                 static_cast<long long>(report.marks_left_out), RecordingSurvey::kMostMarks);
  std::fprintf(stderr, "%s: %.1f MB\n", options.file.c_str(), static_cast<double>(report.bytes) * 1e-6);
}

constexpr const char* kCandump = "candump";

void check_dbc(const ExportOptions& options) {
  const bool is_candump = options.request.format == kCandump;
  if (is_candump && options.dbc.empty())
    throw ConfigError(
        "--dbc: missing; a candump log is nothing without the DBC file that tells what its frames mean");
  if (!is_candump && !options.dbc.empty()) throw ConfigError("--dbc: allowed with --format candump only");
}

int run_export(ExportOptions options) {
  const StopOnSignal signals;
  options.request.folder = options.folder;
  options.request.file = options.file;
  options.request.pulses = options.pulses;
  options.request.marks = options.marks;
  options.request.vehicle = options.vehicle;
  options.request.dbc = options.dbc;
  check_dbc(options);
  if (options.has_to) options.request.selection.to_s = options.to_s;
  const ExportReport report = [&] {
    ProgressLine line;
    return export_recording(options.request, signals.token(),
                            [&](std::int64_t rows, std::int64_t of, std::uintmax_t bytes) {
                              line.show(static_cast<double>(rows) / static_cast<double>(of), bytes);
                            });
  }();
  warn_of_defects("export", options.folder, report.defects);
  tell(options, report);
  if (options.json) std::printf("%s\n", as_text(report_json(options, report)).c_str());
  if (report.defects.any()) return kAnswerIsNo;
  const bool is_whole = report.missing == 0 && report.table.left_out.empty() && report.pulses.left_out == 0 &&
                        report.marks_left_out == 0;
  return is_whole ? kDone : kIncomplete;
}

}  // namespace

void add_export(CLI::App& app, int& code) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = app.add_subcommand("export", "Writes a recording to a file of another format");
  std::vector<std::string> formats;
  for (const auto& format : export_formats()) formats.push_back(format.name);
  command->add_option("folder", options->folder, "the recording")->required();
  command->add_option("--format", options->request.format, "what to write")
      ->required()
      ->check(CLI::IsMember(formats));
  command->add_option("-o,--output", options->file, "file to make; must not be there yet")->required();
  command->add_option("--from", options->request.selection.from_s,
                      "begin, s from the recording's first sample");
  CLI::Option* to = command->add_option("--to", options->to_s, "end, s; not included");
  command
      ->add_option("--channels", options->request.selection.channels,
                   "names of channels or nodes; all if not given")
      ->delimiter(',');
  command->add_option("--pulses", options->pulses,
                      "also write the pulses of the wheels to this file, as rb import csv takes them");
  command->add_option("--marks", options->marks,
                      "also write the marks to this file, as rb import takes them");
  command->add_option("--vehicle", options->vehicle, "also write the recorded vehicle.toml to this file");
  command->add_option("--dbc", options->dbc,
                      "with candump: the DBC file to make, which tells what its frames mean");
  command->add_flag("--json", options->json, "one JSON object on standard output");
  command->footer(
      "Exit codes: 0 done, 3 samples are missing in it and marked so, or left out for nobody can tell their "
      "time, or marks behind the first 100 000 are left out, 1 the recording is damaged and the file holds "
      "the rest, 2 usage, 4 cannot read or write.");
  command->callback([options, to, &code] {
    options->has_to = to->count() > 0;
    code = run_export(*options);
  });
}

}  // namespace roadbalance
