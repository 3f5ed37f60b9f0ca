#pragma once

#include <filesystem>
#include <memory>

#include "host/recording/formats/sample_source.hpp"

namespace roadbalance {

/// Samples in a log of `candump -L`: each signal that the DBC file has of the log's frames is a channel of
/// the signal's name; frames of one stamp are of one instant.  A signal without a frame then, or whose value
/// means so (not available, out of its range), is no sample; frames that the DBC file does not describe,
/// remote and error frames are passed over.
/// Time counts from the first frame, in a log of `rb export` from the recording's start (kCandumpStart). Such
/// a log is taken only with the DBC file of an export of the same channels, whose nodes are the channels'
/// nodes; and such a file only for a log that begins with that frame, which alone tells cars apart.
///
/// @throws ConfigError "file:line: reason; allowed: ..." of the log or the DBC file, reading it too: a line
///         that is none, a time that goes back, a frame shorter than its message, an unknown unit, a signal's
///         name that stands twice; std::system_error if a file cannot be read
std::unique_ptr<SampleSource> open_candump_samples(const std::filesystem::path& log,
                                                   const std::filesystem::path& dbc);

}  // namespace roadbalance
