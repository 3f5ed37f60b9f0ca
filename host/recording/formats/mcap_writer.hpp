#pragma once

#include <filesystem>
#include <memory>

#include "host/recording/formats/writer.hpp"

namespace roadbalance {

/// MCAP, as Foxglove plots it: a topic for each set of instants, in it a message for each instant with a
/// float64 for each channel, in its unit, NaN where there is nothing (encoding cdr, schema ros2msg); topic
/// /marks; metadata `description` (JSON) and vehicle.toml as attachment.  Chunks with index and CRC, not
/// compressed.
///
/// A field has its channel's name in small letters, with _ for characters that ROS 2 allows in no name.  Log
/// times are UTC if the recording has the time of its begin, else they count from its first sample.
/// @throws std::system_error naming the file
std::unique_ptr<ExportWriter> make_mcap_writer(const std::filesystem::path& file, const ExportTable& table);

}  // namespace roadbalance
