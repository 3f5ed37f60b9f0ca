#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "host/recording/formats/writer.hpp"

namespace roadbalance {

/// The DBC file's name for the frame at a recording's start.
inline constexpr const char* kCandumpStart = "recording_start";
inline constexpr const char* kCandumpMeaning = "channels_crc32c";

/// A name as a DBC file may have it: an identifier of C.
std::string dbc_identifier(std::string name);

/// A log as `candump -L` writes and `canplayer` plays it: one frame of four bytes for each sample of each
/// channel, with its counts, at the sample's instant in UTC to a microsecond.  A missing sample has no frame;
/// an instant without any sample has one frame without data.  The log begins with a frame kCandumpStart
/// at the recording's start, from which pulses and marks count, whichever part of the recording
/// is exported.  Its data, and the range of the signal kCandumpMeaning in the DBC file, are a CRC-32C of what
/// all of the vehicle's channels mean: a log is not taken for that of another car.
///
/// A channel's identifier is its place in vehicle.toml, whatever was recorded or is exported of it.
///
/// No bus carries so many frames in such a time: the log is for programs that read logs.
std::unique_ptr<ExportWriter> make_candump_writer(const std::filesystem::path& file,
                                                  const ExportTable& table);

/// The DBC file that describes the frames of such a log: a message and a signal for each channel, with its
/// node, scale and unit.
std::string candump_dbc(const ExportTable& table);

}  // namespace roadbalance
