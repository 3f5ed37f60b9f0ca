#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "common/frontend/front_end.hpp"
#include "host/exchange/sample_table.hpp"

namespace roadbalance {

/// True of the columns <wheel>_angle_sin and <wheel>_angle_cos of `rb export`: they are computed anew from
/// the pulses.
bool is_reference_column(std::string_view name);

/// Samples as somebody else wrote them: a row of channel names, a row of units, then one row an instant.
/// First column time_s [s]; channels in one of kKnownUnits; an empty cell is no sample.
/// @throws ConfigError "file:line: column: reason; allowed: ..."; std::system_error if it cannot be read
SampleTable read_samples(const std::filesystem::path& file);

/// One wheel's edge, not yet given to a node's line.
struct Pulse {
  double time_s;
  int wheel;
  EdgeKind kind;
};

/// Header time_s,wheel,kind; rows in order of time, kind tooth or zero.  Errors as above.
std::vector<Pulse> read_pulses(const std::filesystem::path& file);

/// What a person said during the drive.
struct ImportedMark {
  double time_s;
  std::int64_t number;  ///< from 1 on
  std::string text;
};

/// Header time_s,number,text; rows in order of time, the text in quotes, those in it doubled.  Errors as
/// above.
std::vector<ImportedMark> read_marks(const std::filesystem::path& file);

}  // namespace roadbalance
