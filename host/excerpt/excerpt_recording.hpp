#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "host/analyser/read_recording.hpp"
#include "host/excerpt/excerpt_request.hpp"
#include "host/excerpt/pieces.hpp"
#include "host/exchange/export_table.hpp"
#include "host/recorder/verify.hpp"

namespace roadbalance {

struct ExcerptReport {
  Pieces pieces;                        ///< since the original's first sample
  std::string made_of;                  ///< as the new recording says it of itself
  std::vector<ExportLeftOut> left_out;  ///< of the original: node epochs whose time nobody can tell
  RecordingDefects defects;             ///< of the original
  Verification verification;            ///< of the new recording, read back
  std::uintmax_t bytes = 0;             ///< of it
  double rate_hz = 0.0;                 ///< of its samples
};

/// How far it is: bytes of the original gone through and to go through.
using ExcerptProgress = std::function<void(std::uint64_t bytes, std::uint64_t of)>;

/// Makes a recording of a part of another, which stays as it is.
///
/// Each stretch of time and each node is an epoch of its own, from a first scan to an end, so that it is
/// complete if the original was complete there.  Counts are the original's bit for bit, or every factor-th
/// behind reduction_taps(); stamps of edges and signals, clocks, exchanges with them, marks and what the
/// recorder noted in that time come along, gaps with their causes.  A note says what it was made of.  The
/// same request makes the same blocks.
///
/// The new folder appears whole or not at all.  Takes memory for a few blocks, whatever the length.
/// @throws ConfigError naming the option at fault, std::system_error naming the file, std::runtime_error if
///         the recording cannot be used, the folder holds something already, or `stop` was requested
ExcerptReport excerpt_recording(const ExcerptRequest& request, std::stop_token stop = {},
                                const ExcerptProgress& progress = {});

}  // namespace roadbalance
