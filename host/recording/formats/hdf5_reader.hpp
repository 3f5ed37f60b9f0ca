#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "host/recording/formats/sample_source.hpp"

namespace roadbalance {

/// The samples of an HDF5 file of `rb export`, or of another program that follows the CF conventions:
/// one group that holds a data set `time_s` and, of the same length, a data set for each channel; its
/// attribute `units` is one of kKnownUnits or 1; value = stored * scale_factor + add_offset (1 and 0 if they
/// are not there), none where the stored number is _FillValue or NaN.
/// @throws ConfigError naming the file, the data set and the allowed values, and for damage also its byte;
///         std::runtime_error if the library cannot open an object in the file; std::system_error if the file
///         is not there
///
/// A separate process reads the file (separate_reader.hpp), since damage crashes or hangs the library.
std::unique_ptr<SampleSource> open_hdf5_samples(const std::filesystem::path& file);

/// The same in this process, for programs that the library may crash.
std::unique_ptr<SampleSource> open_hdf5_samples_here(const std::filesystem::path& file);

/// Files, groups and sets that the library has open here; 0 once such sources are gone, even after errors.
std::int64_t open_hdf5_objects();

}  // namespace roadbalance
