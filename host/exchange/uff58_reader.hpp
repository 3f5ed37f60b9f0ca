#pragma once

#include <filesystem>
#include <memory>

#include "host/exchange/sample_source.hpp"

namespace roadbalance {

/// The time responses (data sets 58, function type 1) of an ASCII universal file; data sets of other types
/// are passed over.  All must have the same even abscissa; ordinates single or double precision, real, in SI
/// (data set 164, if there is one, must say so).  The channel's name is the first ID line; "NaN" is no
/// sample.
///
/// Files of `rb export` tell their rate to 15 digits in ID line 4, which then counts.
/// Source: SDRC, Universal File Datasets, types 58 and 164.
/// @throws ConfigError "file:line: reason; allowed: ...", of a value when it is read; std::system_error if it
///         cannot be read
std::unique_ptr<SampleSource> open_uff58_samples(const std::filesystem::path& file);

}  // namespace roadbalance
