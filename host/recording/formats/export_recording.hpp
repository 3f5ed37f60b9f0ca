#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>

#include "host/recording/formats/export_table.hpp"
#include "host/recording/formats/pulses.hpp"
#include "host/recording/formats/survey.hpp"
#include "host/recording/formats/writer.hpp"

namespace roadbalance {

/// A format that recordings can be exported to.
struct ExportFormat {
  std::string name;
  std::unique_ptr<ExportWriter> (*make)(const std::filesystem::path& file, const ExportTable& table);
  /// The least that a file takes for each row, and in it for each channel, missing or not.
  std::uint64_t row_bytes, value_bytes;
};
std::span<const ExportFormat> export_formats();

struct ExportRequest {
  std::filesystem::path folder, file;
  std::string format;
  ExportSelection selection;
  std::filesystem::path pulses = {};   ///< file for the wheels' pulses; empty: none
  std::filesystem::path marks = {};    ///< for the marks
  std::filesystem::path vehicle = {};  ///< for the recorded vehicle.toml
  std::filesystem::path dbc = {};      ///< the same for the DBC file of a candump log
};

struct ExportReport {
  ExportTable table;  ///< of the exported part
  RecordingDefects defects;
  std::int64_t rows = 0;     ///< of all groups
  std::int64_t missing = 0;  ///< of them, summed over nodes, those without samples
  WrittenPulses pulses = {};
  std::int64_t marks_left_out = 0;  ///< of the recording, behind the first RecordingSurvey::kMostMarks
  std::uintmax_t bytes = 0;         ///< of the file
};

/// Progress: rows written and to write, bytes written.
using ExportProgress = std::function<void(std::int64_t rows, std::int64_t of, std::uintmax_t bytes)>;

/// Writes a recording to a file, which appears under its name complete or not at all.  Takes memory for a few
/// thousand rows, whatever the length.
/// @throws ConfigError naming the format or option at fault, std::system_error naming the file, std::
///         runtime_error if the recording cannot be used or `stop` was requested
ExportReport export_recording(const ExportRequest& request, std::stop_token stop = {},
                              const ExportProgress& progress = {});

}  // namespace roadbalance
