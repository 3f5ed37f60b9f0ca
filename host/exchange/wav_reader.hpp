#pragma once

#include <filesystem>
#include <memory>

#include "host/exchange/sample_source.hpp"

namespace roadbalance {

/// The samples of a WAV or RF64 file that `rb export` wrote: its comment tells channels, scales and the true
/// rate. What stands there for a missing sample (kWavMissing) is none again.
/// @throws ConfigError naming the file and what is allowed; std::system_error if it is not there
std::unique_ptr<SampleSource> open_wav_samples(const std::filesystem::path& file);

}  // namespace roadbalance
