#pragma once

#include <filesystem>
#include <memory>

#include "host/exchange/writer.hpp"

namespace roadbalance {

/// MAT-file of level 5, as MATLAB, Octave and SciPy load it: a column of doubles for each channel, in its
/// unit, NaN where there is nothing; `<group>_time_s` for each set of instants; `description` (JSON text).
///
/// A double tells every count exactly.  A channel's name is its variable's, with _ for what MATLAB allows in
/// no name and x before a first character that is no letter.
///
/// Own code, for libmatio takes a whole variable into memory.  Source: MathWorks, MAT-File Format, R2019b,
/// chapter 1 (level 5).
/// @throws ConfigError if a variable would exceed 2 GB, std::system_error naming the file
std::unique_ptr<ExportWriter> make_mat_writer(const std::filesystem::path& file, const ExportTable& table);

}  // namespace roadbalance
