#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/clock/bounded_time.hpp"
#include "common/config/vehicle_config.hpp"
#include "host/analyser/read_recording.hpp"
#include "host/exchange/export_table.hpp"

namespace roadbalance {

/// A node epoch as far as there are samples or gaps of it in a recording.
struct RecordedSpan {
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t first_scan = 0, next_scan = 0;
  std::int64_t samples = 0;  ///< of these, that are recorded
  std::int64_t period_ps = 0;
  std::int64_t first_ns = 0, last_ns = 0;  ///< node time of first_scan; of next_scan
  std::optional<ClockFit> first_fit = {};  ///< nothing: no fit of its clock is in the recording
  std::int64_t last_host_ns = 0;           ///< of next_scan, by the last fit before it
  std::int32_t overload = 0;               ///< bit k: channel k left its range

  std::int64_t first_host_ns() const { return first_fit ? host_instant_ns(*first_fit, first_ns) : first_ns; }
  std::int64_t end_ns() const { return first_fit ? last_host_ns : last_ns; }
};

/// Everything that must be known of a recording before its samples are gone through.
struct RecordingSurvey {
  VehicleConfig vehicle = {};
  std::string program = {};
  std::vector<RecordedSpan> span = {};  ///< in the order in which they began
  RecordingDefects defects = {};
  std::optional<std::int64_t> start_utc_us = {};  ///< of the first sample
  bool start_by_clock = false;
  struct Mark {
    std::int64_t host_ns, last_sample_ns, number;  ///< last_sample_ns: node time of the samples beside it
    std::string text;
  };
  /// More are made by nobody: memory is bounded whatever the record holds.
  static constexpr std::size_t kMostMarks = 100'000;
  std::vector<Mark> mark = {};      ///< the first of them
  std::int64_t marks_left_out = 0;  ///< those behind
  bool imported = false;            ///< from a file of another program

  /// The recording tells the host's time; a node epoch without a fit then has none.
  bool own_clocks() const {
    return std::any_of(span.begin(), span.end(), [](const auto& s) { return s.first_fit.has_value(); });
  }
  /// Notes bear the time that the samples are told in; without it they stand beside the samples that came
  /// with them.
  bool notes_tell_time() const { return imported || own_clocks(); }
};

/// Reads a recording once.
/// @throws std::system_error if the folder cannot be read, std::runtime_error if it holds no vehicle.toml or
///         no sample, or `stop` is requested
RecordingSurvey survey_recording(const std::filesystem::path& folder, std::stop_token stop = {});

/// The channels and groups of a recording.
///
/// Node epochs without clocks of their own (one time by construction: an import, a simulation faster than
/// real time) whose samples lie on one grid make one group.  Every other node epoch is a group of its own;
/// one without a fit beside others that have theirs is left out, for nobody can tell its time.
ExportTable make_table(const RecordingSurvey& survey);

/// What of it is wanted.
struct ExportSelection {
  double from_s = 0.0;
  std::optional<double> to_s = {};         ///< not included
  std::vector<std::string> channels = {};  ///< names of channels or nodes; empty: all
};

/// Narrows the table to what is wanted; in groups of nodes with clocks of their own the limits are met to
/// what their mean rate tells.
/// @throws ConfigError naming the option if nothing is left or a name is not known
void select(const ExportSelection& selection, ExportTable& table);

}  // namespace roadbalance
