#pragma once

#include <filesystem>
#include <string>

#include "host/analysis/balance/readings.hpp"

namespace roadbalance {

/// A table of readings as people write it, comma-separated: a row of names, a row of units, a row for each
/// run.
///
///     run,turns,weight hub,front,sigma front
///     ,1/s,g,mm/s,mm/s
///     bare,49.0,,3.4@116,0.1
///     trial,49.1,2.0@0,1.8@42,0.1
///
/// `run` comes first.  `speed` or `turns` is the speed, one unit for all.  `weight PLANE` is
/// AMOUNT@DEGREES, or empty: none.  `sigma CHANNEL` is one standard deviation of the channel's amplitude, or
/// empty: not known.  Every other column is a channel, AMPLITUDE@DEGREES.
struct ReadingsFile {
  Readings readings;
  std::string speed_unit, weight_unit, reading_unit;

  /// @throws ConfigError "file:line: column: reason; allowed: ..."; std::system_error if it cannot be read
  static ReadingsFile read(const std::filesystem::path& file);
};

}  // namespace roadbalance
