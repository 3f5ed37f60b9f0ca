#include "host/recording/formats/export_recording.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/section.hpp"
#include "common/record/file.hpp"
#include "common/record/part.hpp"
#include "common/record/room.hpp"
#include "host/recording/formats/byte_sink.hpp"
#include "host/recording/formats/candump_writer.hpp"
#include "host/recording/formats/csv_text.hpp"
#include "host/recording/formats/csv_writer.hpp"
#include "host/recording/formats/decimal_text.hpp"
#include "host/recording/formats/hdf5_writer.hpp"
#include "host/recording/formats/mat_writer.hpp"
#include "host/recording/formats/mcap_writer.hpp"
#include "host/recording/formats/mdf4_writer.hpp"
#include "host/recording/formats/row_stream.hpp"
#include "host/recording/formats/uff58_writer.hpp"
#include "host/recording/formats/wav_writer.hpp"

namespace roadbalance {
namespace {

const ExportFormat& format_named(const std::string& name) {
  std::string all;
  for (const auto& format : export_formats()) {
    if (format.name == name) return format;
    all += " " + format.name;
  }
  throw ConfigError("--format: " + name + ": no such format; allowed:" + all);
}

void write_groups(const ExportRequest& request, ExportWriter& writer, const std::filesystem::path& part,
                  const std::stop_token& stop, const ExportProgress& progress, ExportReport& report) {
  std::int64_t all = 0;
  for (const auto& group : report.table.group) all += group.rows;
  for (std::size_t g = 0; g < report.table.group.size(); ++g) {
    RowStream stream(request.folder, report.table, g);
    for (auto rows = stream.next(); rows.rows() > 0; rows = stream.next()) {
      if (stop.stop_requested())
        throw std::runtime_error("stopped; nothing is left of " + request.file.string());
      writer.add(g, rows);
      report.rows += static_cast<std::int64_t>(rows.rows());
      if (progress) progress(report.rows, all, std::filesystem::file_size(part));
    }
    report.missing += stream.missing();
  }
}

std::uint64_t least_bytes(const ExportFormat& format, const ExportTable& table) {
  std::uint64_t bytes = 0;
  for (const ExportGroup& group : table.group)
    bytes += static_cast<std::uint64_t>(group.rows) *
             (format.row_bytes + format.value_bytes * group.channel.size());
  return bytes;
}

std::string in_quotes(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    // A cell is one line: a line break becomes a blank.
    quoted += c == '\n' || c == '\r' ? ' ' : c;
    if (c == '"') quoted += c;
  }
  return quoted + "\"";
}

/// Writes the marks as `rb import` reads them: time_s,number,text in order of time, the text in quotes,
/// quotes in it doubled.
/// @throws std::system_error naming the file
void write_marks(const ExportTable& table, const std::filesystem::path& file) {
  std::vector<ExportMark> marks = table.mark;
  std::stable_sort(marks.begin(), marks.end(),
                   [](const auto& a, const auto& b) { return a.time_ns < b.time_ns; });
  ByteSink sink(file);
  sink.put("time_s,number,text\n");
  for (const ExportMark& mark : marks) {
    std::array<char, kDecimalText> text;
    const char* end = write_decimal(text.data(), mark.time_ns, 9);
    sink.put(std::string_view(text.data(), static_cast<std::size_t>(end - text.data())));
    sink.put("," + std::to_string(mark.number) + "," + in_quotes(protected_text(mark.text)) + "\n");
  }
  sink.close();
}

/// A file to make beside the export, if it is asked for.
struct Beside {
  const char* option;
  const std::filesystem::path& path;
  std::optional<Part> part{};
};

/// Checks that each file has a place of its own, and none is in the recording.
void expect_apart(const ExportRequest& request, std::span<const Beside> all) {
  const auto place = [](const std::filesystem::path& path) {
    return std::filesystem::absolute(path).lexically_normal();
  };
  expect_beside({request.folder}, request.file);
  std::vector<std::filesystem::path> taken{place(request.file)};
  for (const Beside& one : all) {
    if (one.path.empty()) continue;
    expect_beside({request.folder}, one.path);
    if (std::ranges::find(taken, place(one.path)) != taken.end())
      throw ConfigError(std::string(one.option) + ": " + one.path.string() +
                        ": is another file to make, too");
    taken.push_back(place(one.path));
  }
}

}  // namespace

std::span<const ExportFormat> export_formats() {
  // Text formats: a comma for a missing value; a frame for each instant; numbers of fixed width.
  static const std::array kFormats{
      ExportFormat{"candump", make_candump_writer, 20, 0}, ExportFormat{"csv", make_csv_writer, 0, 1},
      ExportFormat{"hdf5", make_hdf5_writer, 8, 4},        ExportFormat{"mat", make_mat_writer, 8, 8},
      ExportFormat{"mcap", make_mcap_writer, 0, 8},        ExportFormat{"mdf4", make_mdf4_writer, 8, 4},
      ExportFormat{"uff58", make_uff58_writer, 0, 20},     ExportFormat{"wav", make_wav_writer, 0, 4}};
  return kFormats;
}

ExportReport export_recording(const ExportRequest& request, std::stop_token stop,
                              const ExportProgress& progress) {
  const ExportFormat& format = format_named(request.format);
  std::array<Beside, 4> all{{{"--pulses", request.pulses},
                             {"--marks", request.marks},
                             {"--vehicle", request.vehicle},
                             {"--dbc", request.dbc}}};
  auto& [pulses, marks, vehicle, dbc] = all;
  expect_apart(request, all);
  Part file(request.file, Part::Kind::kFile);
  for (Beside& beside : all)
    if (!beside.path.empty()) beside.part.emplace(beside.path, Part::Kind::kFile);
  const RecordingSurvey survey = survey_recording(request.folder, stop);
  ExportReport report{.table = make_table(survey), .defects = survey.defects};
  report.marks_left_out = survey.marks_left_out;
  select(request.selection, report.table);
  expect_room(file.place(), least_bytes(format, report.table));
  const auto writer = format.make(file.part(), report.table);
  write_groups(request, *writer, file.part(), stop, progress, report);
  writer->close();
  if (pulses.part)
    report.pulses =
        write_pulses(request.folder, survey, report.table, request.selection, pulses.part->part(), stop);
  if (marks.part) write_marks(report.table, marks.part->part());
  if (vehicle.part) write_atomically(vehicle.part->part(), report.table.vehicle_toml);
  if (dbc.part) write_atomically(dbc.part->part(), candump_dbc(report.table));
  report.bytes = std::filesystem::file_size(file.part());
  // The file itself last: it is useless without the others.
  for (Beside& beside : all)
    if (beside.part) beside.part->keep();
  file.keep();
  return report;
}

}  // namespace roadbalance
