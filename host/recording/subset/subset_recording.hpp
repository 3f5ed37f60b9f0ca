#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "host/recording/formats/export_table.hpp"
#include "host/recording/read_recording.hpp"
#include "host/recording/subset/pieces.hpp"
#include "host/recording/subset/subset_request.hpp"
#include "host/recording/verify/verify.hpp"

namespace roadbalance {

struct SubsetReport {
  Pieces pieces;                        ///< since the original's first sample
  std::string made_of;                  ///< the description in the new recording's note
  std::vector<ExportLeftOut> left_out;  ///< node epochs of the original whose time is unknown
  RecordingDefects defects;             ///< of the original
  Verification verification;            ///< of the new recording, read back
  std::uintmax_t bytes = 0;             ///< of the new recording
  double rate_hz = 0.0;                 ///< of its samples
};

/// Progress: bytes of the original read and to read.
using SubsetProgress = std::function<void(std::uint64_t bytes, std::uint64_t of)>;

/// Makes a recording of a part of another, which is only read.
///
/// Each stretch of time of each node is an epoch of its own, from a first scan to an end, so that it is
/// complete if the original was complete there.  Counts are the original's bit for bit, or every factor-th
/// behind reduction_taps().  Stamps of edges and signals, clock fits and exchanges, marks and the recorder's
/// notes of that time are copied, gaps with their causes.  A note describes the source.  The same request
/// makes the same blocks.
///
/// The new folder appears complete or not at all.  Takes memory for a few blocks, whatever the length.
/// @throws ConfigError naming the option at fault, std::system_error naming the file, std::runtime_error if
///         the recording cannot be used, the folder holds something already, or `stop` was requested
SubsetReport subset_recording(const SubsetRequest& request, std::stop_token stop = {},
                              const SubsetProgress& progress = {});

}  // namespace roadbalance
