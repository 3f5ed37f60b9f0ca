#pragma once

#include <filesystem>
#include <memory>

#include "host/recording/formats/writer.hpp"

namespace roadbalance {

/// WAV, 32-bit PCM; RF64 beyond 4 GB.  A sample is its counts times kWavSamplesPerCount, so that no count is
/// lost and full scale is a quarter below the format's.  The comment (INFO ICMT) is the description as JSON,
/// with scale and offset of each channel: value = (sample / 128 - offset_counts) * scale.
///
/// The format has no missing samples: there the sample is silence, the counts of a value of 0, and
/// `rb export --json` counts them.  Its rate is a whole number; the true one is in the comment.
/// @throws ConfigError if the table has more than one group or 1024 channels
std::unique_ptr<ExportWriter> make_wav_writer(const std::filesystem::path& file, const ExportTable& table);

}  // namespace roadbalance
