#pragma once

#include <filesystem>
#include <memory>

#include "host/recording/formats/writer.hpp"

namespace roadbalance {

/// ASAM MDF 4.10: a sorted data group for each set of instants, time as master channel (double, s from the
/// recording's first sample), counts as 32-bit integers with a linear conversion, invalidation bits where
/// samples are missing; marks as events, vehicle.toml attached.  Not compressed.
/// @throws std::system_error naming the file
std::unique_ptr<ExportWriter> make_mdf4_writer(const std::filesystem::path& file, const ExportTable& table);

}  // namespace roadbalance
