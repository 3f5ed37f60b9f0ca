#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace roadbalance::sim {

/// "PATH?seed=7&rate=20&seconds=320&start_ns=123&from=12.5&converter_ppm=40", every part optional: the
/// address of a simulated front end.
///
/// A node's converter may be faster than its nominal rate by converter_ppm: it then takes other instants of
/// the same drive.  A node's clock may show clock_offset_s at bus time 0 and gain clock_ppm on it; only with
/// rate=1, for at any other rate all nodes have bus time in common.
struct Address {
  std::string scenario_path;          ///< empty: the demo scenario
  std::optional<std::uint64_t> seed;  ///< default: the scenario's
  std::optional<double> rate = 1.0;   ///< bus seconds a wall second; nothing ("max"): as fast as it is read
  std::optional<double> seconds;      ///< length of the drive; default: the scenario's
  std::optional<std::int64_t> start_ns;  ///< CLOCK_BOOTTIME at bus time 0; default: when opened
  double from_s = 0.0;                   ///< bus time before which nothing is delivered
  double clock_offset_s = 0.0;           ///< -1e6 .. 1e6
  double clock_ppm = 0.0;                ///< -500 .. 500
  double converter_ppm = 0.0;            ///< -500 .. 500

  /// @throws ConfigError naming the key and what is allowed
  static Address parse(const std::string& text);
};

}  // namespace roadbalance::sim
