#pragma once

#include <filesystem>
#include <memory>

#include "host/recording/formats/writer.hpp"

namespace roadbalance {

/// HDF5: a group for each set of instants, in it `time_s` (double, from the recording's first sample) and a
/// data set of the counts (32 bit) for each channel, chunked.
///
/// Attributes of a data set follow the CF conventions, by which readers (xarray, netCDF4, MATLAB's ncread)
/// give values by themselves: value = counts * scale_factor + add_offset, none where counts are _FillValue;
/// beside them units, node, mount, position_m, direction, range, delay_s, overload.  Attributes of the file:
/// description (JSON), vehicle_toml, start_utc_us.
/// @throws std::system_error, std::runtime_error naming the file
std::unique_ptr<ExportWriter> make_hdf5_writer(const std::filesystem::path& file, const ExportTable& table);

}  // namespace roadbalance
