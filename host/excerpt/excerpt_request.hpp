#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "host/excerpt/channel_choice.hpp"

namespace roadbalance {

/// Which time of a recording is wanted: what all of these allow.
struct TimeChoice {
  /// Seconds from the recording's first sample, or from a mark of that number; `to` is not included.
  std::optional<double> from_s = {}, to_s = {};
  std::optional<std::int64_t> from_mark = {}, to_mark = {};
  /// Speed of the car, m/s, by the wheels of the first node that reads one; the upper one is not included.
  std::optional<double> least_m_s = {}, most_m_s = {};
  /// Where every chosen node has all its samples, all chosen channels are in range and all angles known.
  bool clean = false;
  /// Shorter stretches that speed or clean leave are left out, too.
  double least_s = 1.0;

  bool asks_samples() const { return least_m_s || most_m_s || clean; }
};

/// A recording to be made of a part of another.
struct ExcerptRequest {
  std::filesystem::path folder, output;
  ChannelChoice choice = {};
  TimeChoice time = {};
  int factor = 1;  ///< every so many samples one is left, behind reduction_taps()
};

}  // namespace roadbalance
