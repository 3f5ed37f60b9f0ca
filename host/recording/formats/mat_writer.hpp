#pragma once

#include <filesystem>
#include <memory>

#include "host/recording/formats/writer.hpp"

namespace roadbalance {

/// MAT-file of level 5, as MATLAB, Octave and SciPy load it: a column of doubles for each channel, in its
/// unit, NaN for missing samples; `<group>_time_s` for each set of instants; `description` (JSON text).
///
/// A double holds every count exactly.  A variable has its channel's name, with _ for characters that MATLAB
/// allows in no name, and x before a first character that is no letter.
///
/// Own code, since libmatio holds a whole variable in memory.  Source: MathWorks, MAT-File Format, R2019b,
/// chapter 1 (level 5).
/// @throws ConfigError if a variable would exceed 2 GB, std::system_error naming the file
std::unique_ptr<ExportWriter> make_mat_writer(const std::filesystem::path& file, const ExportTable& table);

}  // namespace roadbalance
