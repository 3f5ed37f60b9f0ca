#pragma once

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
std::unique_ptr<SampleSource> open_hdf5_samples(const std::filesystem::path& file);

}  // namespace roadbalance
