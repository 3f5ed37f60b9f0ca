#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "host/exchange/sample_source.hpp"

namespace roadbalance {

/// The samples of an HDF5 file as `rb export` writes it, or somebody else who keeps to the CF conventions:
/// one group that holds a data set `time_s` and, of the same length, a data set for each channel; its
/// attribute `units` is one of kKnownUnits or 1; value = stored * scale_factor + add_offset (1 and 0 if they
/// are not there), none where the stored number is _FillValue or NaN.
/// @throws ConfigError naming the file, the data set and what is allowed, of damage also the byte where it
///         stands; std::runtime_error if the library cannot open what is in the file; std::system_error if it
///         is not there
///
/// A process of its own reads it (separate_reader.hpp), for the library comes to grief over damage.
std::unique_ptr<SampleSource> open_hdf5_samples(const std::filesystem::path& file);

/// The same by this process itself, for whoever can bear that the library ends it.
std::unique_ptr<SampleSource> open_hdf5_samples_here(const std::filesystem::path& file);

/// Files, groups and sets that the library has open here; 0 once such sources have gone, whatever they met.
std::int64_t open_hdf5_objects();

}  // namespace roadbalance
