#pragma once

#include <map>
#include <string>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/spectra/joint_spectra.hpp"

namespace roadbalance {

/// Common parts of the commands that make spectra of a recording.

/// @param option  that named the channel, for the error
/// @throws ConfigError listing the channels there are
ChannelPlace find_channel(const VehicleConfig& vehicle, const std::string& option, const std::string& name);

/// Default length of the segments of a spectrum.
inline constexpr double kSegment_s = 4.0;
int segment_samples(double segment_s, double rate_hz);

/// By their names as options.
const std::map<std::string, Window>& windows_by_name();

/// Reports on standard error why not one segment was found.
void say_no_segment(const char* command, const JointSpectra& spectra);

}  // namespace roadbalance
