#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "host/exchange/writer.hpp"

namespace roadbalance {

/// What the DBC file calls the frame that tells a recording's start.
inline constexpr const char* kCandumpStart = "recording_start";

/// A log as `candump -L` writes and `canplayer` plays: one frame of four bytes for each sample of each
/// channel, its counts as they are, at the sample's instant in UTC to a microsecond.  What is missing has no
/// frame; an instant without any has one of no data.  First of all stands a frame kCandumpStart of no data at
/// the recording's start, from which pulses and marks count, whatever of the recording is exported.
///
/// No bus carries so many frames in such a time: the log is for programs that read logs.
std::unique_ptr<ExportWriter> make_candump_writer(const std::filesystem::path& file,
                                                  const ExportTable& table);

/// The DBC file that tells a program what the frames of such a log mean: a message and a signal for each
/// channel, with its scale and unit.
std::string candump_dbc(const ExportTable& table);

}  // namespace roadbalance
