#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "host/recording/subset/channel_choice.hpp"

namespace roadbalance {

/// The wanted time of a recording: all of these conditions hold.
struct TimeChoice {
  /// Seconds from the recording's first sample, or from the mark of that number; `to` is not included.
  std::optional<double> from_s = {}, to_s = {};
  std::optional<std::int64_t> from_mark = {}, to_mark = {};
  /// Speed of the car, m/s, by the wheels of the first node that reads one; the upper one is not included.
  std::optional<double> least_m_s = {}, most_m_s = {};
  /// Only where every chosen node has all its samples, all chosen channels are in range and all angles known.
  bool clean = false;
  /// Shorter stretches within the limits of speed and quality are left out.
  double least_s = 1.0;

  bool asks_samples() const { return least_m_s || most_m_s || clean; }
};

/// A request for a new recording of a part of another.
struct SubsetRequest {
  std::filesystem::path folder, output;
  ChannelChoice choice = {};
  TimeChoice time = {};
  int factor = 1;  ///< one of so many samples is kept, behind reduction_taps()
};

}  // namespace roadbalance
