#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "host/analysis/twin/twin_shares.hpp"
#include "host/recording/read_recording.hpp"

namespace roadbalance {

struct TwinRequest {
  std::filesystem::path folder;
  double from_s = 0.0;  ///< of the account, from the first sample; what is before only settles the twin
  double to_s = std::numeric_limits<double>::infinity();
  bool refine = false;  ///< as identify_record
  /// Instead of the recording's estimate.
  std::optional<TwinCar> car{};
};

struct RecordedTwin {
  VehicleConfig vehicle;
  TwinChannels channels;
  TwinCar car;
  std::vector<TwinAccount> total;  ///< [channels]
  std::vector<int> seconds;        ///< [channels] that are in it
  double behind_s = 0.0, settling_s = 0.0;
  std::string refusal;  ///< why the car is not identified, or nodes have no time in common; empty: nothing
  RecordingDefects defects;
};

/// Hears each sample of the account, at so many seconds from the first.
using OnTwinSample = std::function<void(double, const TwinSample&)>;

/// The twin of a finished recording: by the estimate from all of the recording, from its first sample on.
///
/// @param begin  hears the channels before the first sample
/// @param stop   asked between blocks
/// @throws as identify_record; ConfigError if the sensors do not determine the seven coordinates
RecordedTwin twin_of_record(const TwinRequest& request,
                            const std::function<void(const VehicleConfig&, const TwinChannels&)>& begin = {},
                            const OnTwinSample& on_sample = {}, const std::stop_token& stop = {});

}  // namespace roadbalance
