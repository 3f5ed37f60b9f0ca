#pragma once

#include <filesystem>
#include <memory>

#include "host/recording/formats/sample_source.hpp"

namespace roadbalance {

/// The time responses (data sets 58, function type 1) of an ASCII universal file; data sets of other types
/// are skipped.  All must have the same even abscissa of time in s; ordinates single or double precision,
/// real. The channel's name is the first ID line; "NaN" is no sample.
///
/// A channel's unit is the label in record 9, or where that is NONE a unit at the end of its axis' label
/// ("Acceleration g").  Where there is neither the kind of quantity in record 9 decides it, in the lengths of
/// the last data set 164 before it.  Without one there is no unit.  The standard does not say how far a data
/// set 164 reaches: one that stands only behind the channel makes a unit that nobody knows.
///
/// Files of `rb export` have their rate with 15 digits in ID line 4, which then counts.
/// Source: SDRC, Universal File Datasets, types 58 and 164.
/// @throws ConfigError "file:line: reason; allowed: ...", for a value when it is read; std::system_error if
/// the
///         file cannot be read
std::unique_ptr<SampleSource> open_uff58_samples(const std::filesystem::path& file);

}  // namespace roadbalance
