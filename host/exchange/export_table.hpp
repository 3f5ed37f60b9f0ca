#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/clock/exchange.hpp"

namespace roadbalance {

/// What an export says of a recording before its samples: files begin with it.

/// Counts that are not there: lost, declared a gap, or a reference without an angle.  Converters are 24 bit.
inline constexpr std::int32_t kMissingCounts = std::numeric_limits<std::int32_t>::min();

/// One channel: value = (counts - offset_counts) * scale, in `unit`.
struct ExportChannel {
  std::string name = {};  ///< as in vehicle.toml; references are called <wheel>_angle_sin, <wheel>_angle_cos
  std::string unit = {};  ///< m/s^2, of references 1
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
  std::int32_t node = 0;
  std::int64_t epoch = 0;
  std::int64_t first_scan = 0;              ///< is row `first_row`
  std::int64_t first_row = 0;               ///< of the whole group, before --from
  std::size_t first_column = 0;             ///< of its channels in the group
  std::vector<std::size_t> converter = {};  ///< [column - first_column]: place in the node's scans
  std::optional<ClockFit> first_fit = {};   ///< of the node's clock; nothing: the recording has none
};

/// Channels that have their samples at the same instants.  Row k stands at about first_ns + k / rate_hz; each
/// block of rows says it exactly.
struct ExportGroup {
  std::string name = {};
  double rate_hz = 0.0;        ///< in the mean
  std::int64_t first_ns = 0;   ///< of the first row to export, since ExportTable::start_ns
  std::int64_t origin_ns = 0;  ///< of the first in the recording, as it tells time
  std::int64_t first_row = 0;  ///< to export, counted from the first in the recording
  std::int64_t rows = 0;       ///< to export; what is missing among them included
  std::int64_t period_ps = 0;
  bool shared_time = false;  ///< rows are exactly a period apart
  std::vector<ExportChannel> channel = {};
  std::vector<ExportPart> part = {};
};

/// What a person said during the drive.
struct ExportMark {
  std::int64_t time_ns = 0;  ///< since ExportTable::start_ns
  std::int64_t number = 0;
  std::string text = {};
};

/// Samples of a node whose time nobody can tell, for its clock was never known.
struct ExportLeftOut {
  std::string node = {};
  std::int64_t samples = 0;  ///< of each channel
};

struct ExportTable {
  std::string vehicle = {};       ///< its name
  std::string vehicle_toml = {};  ///< its whole description
  std::string program = {};       ///< that made the recording
  std::int64_t start_ns = 0;      ///< of the first row of all, in the recording's time; times count from here
  std::optional<std::int64_t> start_utc_us = {};  ///< the same in UTC
  bool own_clocks = false;                        ///< the recording tells the host's time; else the nodes'
  bool start_by_clock = false;  ///< by the recorded clocks; else by the first block's arrival
  std::vector<ExportGroup> group = {};
  std::vector<ExportMark> mark = {};
  std::vector<ExportLeftOut> left_out = {};
};

}  // namespace roadbalance
