#pragma once

#include <filesystem>
#include <memory>

#include "host/recording/formats/writer.hpp"

namespace roadbalance {

/// Universal file, ASCII: a data set 151 (header) and 164 (units: SI), then a data set 58 for each channel:
/// time response (function type 1), double precision, even abscissa, specific data type 12 (acceleration) or
/// 8 (displacement, of a road) or 0 (of a wheel's angle).  Values have 13 digits, so every count can be
/// computed.
///
/// Missing samples are written "NaN": the format has nothing for them, and an invented number would be worse.
/// The abscissa is even at the mean rate, with 6 digits in record 7 and 15 in ID line 4.
/// @throws std::system_error naming the file
std::unique_ptr<ExportWriter> make_uff58_writer(const std::filesystem::path& file, const ExportTable& table);

}  // namespace roadbalance
