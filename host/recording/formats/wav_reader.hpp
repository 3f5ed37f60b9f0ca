#pragma once

#include <filesystem>
#include <memory>

#include "host/recording/formats/sample_source.hpp"

namespace roadbalance {

/// The samples of a WAV or RF64 file that `rb export` wrote: its comment has channels, scales and the true
/// rate. The value that stands for a missing sample (kWavMissing) becomes a missing one again.
/// @throws ConfigError naming the file and the allowed values; std::system_error if it is not there
std::unique_ptr<SampleSource> open_wav_samples(const std::filesystem::path& file);

}  // namespace roadbalance
