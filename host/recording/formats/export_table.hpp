#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/types/exchange.hpp"

namespace roadbalance {

struct RecordingSurvey;

/// The description of a recording with which exported files begin, before the samples.

/// Missing counts: lost, declared a gap, or a reference without an angle.  Converters have 24 bits.
inline constexpr std::int32_t kMissingCounts = std::numeric_limits<std::int32_t>::min();

/// One channel: value = (counts - offset_counts) * scale, in `unit`.
struct ExportChannel {
  std::size_t number = 0;  ///< among all that can be exported of the vehicle, in the order of vehicle.toml
  std::string name = {};   ///< as in vehicle.toml, made unique (with_unique_names()); references are called
                           ///< <wheel>_angle_sin, <wheel>_angle_cos
  std::string unit = {};   ///< m/s^2, of references 1
  std::string node = {};
  double scale = 1.0;
  double offset_counts = 0.0;
  std::string mount = {};               ///< body or a wheel; of a reference the wheel
  Eigen::Vector3d position_m{0, 0, 0};  ///< from the body's centre of mass
  Eigen::Vector3d direction{0, 0, 0};   ///< of positive acceleration; zero: none
  double range = 0.0;                   ///< full scale, in `unit`
  double delay_s = 0.0;                 ///< by which it lags what it measures
  bool overload = false;                ///< it left its range somewhere in the recording

  double value(std::int32_t counts) const { return (static_cast<double>(counts) - offset_counts) * scale; }
};

/// A node epoch's place in a group.
struct ExportPart {
  struct Column {
    std::size_t converter = 0;  ///< place in the node's scans
    std::size_t column = 0;     ///< in the group
  };
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t first_scan = 0;  ///< is row `first_row`
  std::int64_t first_row = 0;   ///< of the whole group, before --from
  std::vector<Column> column = {};
  std::optional<ClockFit> first_fit = {};  ///< of the node's clock; nothing: the recording has none
};

/// Channels that have their samples at the same instants.  Row k stands at about first_ns + k / rate_hz; each
/// block of rows has it exactly.
struct ExportGroup {
  std::string name = {};
  double rate_hz = 0.0;        ///< in the mean
  std::int64_t first_ns = 0;   ///< of the first row to export, since ExportTable::start_ns
  std::int64_t origin_ns = 0;  ///< of the first in the recording, on the recording's clock
  std::int64_t first_row = 0;  ///< to export, counted from the first in the recording
  std::int64_t rows = 0;       ///< to export; what is missing among them included
  std::int64_t period_ps = 0;
  bool shared_time = false;  ///< rows are exactly a period apart
  std::vector<ExportChannel> channel = {};
  std::vector<ExportPart> part = {};
};

/// A person's remark during the drive.
struct ExportMark {
  std::int64_t time_ns = 0;  ///< since ExportTable::start_ns
  std::int64_t number = 0;
  std::string text = {};
};

/// Samples of a node whose time is unknown, since its clock was never known.
struct ExportLeftOut {
  std::string node = {};
  std::int64_t samples = 0;  ///< of each channel
};

struct ExportTable {
  std::string vehicle = {};       ///< its name
  std::string vehicle_toml = {};  ///< its whole description
  std::string program = {};       ///< that made the recording
  std::uint32_t meaning_crc32c =
      0;                      ///< of names, nodes, units, scales and offsets of all the vehicle's channels
  std::int64_t start_ns = 0;  ///< of the first row of all, in the recording's time; times count from here
  std::optional<std::int64_t> start_utc_us = {};  ///< the same in UTC
  bool own_clocks = false;                        ///< the recording has the host's time; else the nodes'
  bool start_by_clock = false;  ///< by the recorded clocks; else by the first block's arrival
  std::vector<ExportGroup> group = {};
  std::vector<ExportMark> mark = {};
  std::vector<ExportLeftOut> left_out = {};
};

/// The channels and groups of a recording.
///
/// Node epochs without clocks of their own (one time by construction: an import, a simulation faster than
/// real time) whose samples lie on one grid make one group.  Every other node epoch is a group of its own;
/// one without a fit beside others that have theirs is left out, since its time is unknown.
///
/// Groups and channels stand in the order of vehicle.toml's nodes, whichever node was heard first: the same
/// channel has the same name and number in every recording of a car.
ExportTable make_table(const RecordingSurvey& survey);

/// The wanted part of a table.
struct ExportSelection {
  double from_s = 0.0;
  std::optional<double> to_s = {};         ///< not included
  std::vector<std::string> channels = {};  ///< names of channels or nodes, in this order; empty: all
};

/// Narrows the table to the wanted part; in groups of nodes with clocks of their own the limits are as exact
/// as the mean rate.
/// @throws ConfigError naming the option if nothing is left or a name is unknown
void select(const ExportSelection& selection, ExportTable& table);

}  // namespace roadbalance
