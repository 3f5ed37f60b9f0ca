#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/types/bounded_time.hpp"
#include "common/types/exchange.hpp"
#include "host/recording/read_recording.hpp"

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

/// The facts about a recording that are needed before its samples are read.
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
  /// More than any person makes: memory is bounded whatever the record holds.
  static constexpr std::size_t kMostMarks = 100'000;
  std::vector<Mark> mark = {};      ///< the first of them
  std::int64_t marks_left_out = 0;  ///< those behind
  bool imported = false;            ///< from a file of another program

  /// The recording has the host's time; then the time of a node epoch without a fit is unknown.
  bool own_clocks() const {
    return std::any_of(span.begin(), span.end(), [](const auto& s) { return s.first_fit.has_value(); });
  }
  /// Notes bear a time on the samples' clock; otherwise they belong to the samples that came with them.
  bool notes_have_time() const { return imported || own_clocks(); }
};

/// Reads a recording once.
/// @throws std::system_error if the folder cannot be read, std::runtime_error if it holds no vehicle.toml or
///         no sample, or `stop` is requested
RecordingSurvey survey_recording(const std::filesystem::path& folder, std::stop_token stop = {});

}  // namespace roadbalance
