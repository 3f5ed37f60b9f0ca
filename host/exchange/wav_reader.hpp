#pragma once

#include <filesystem>

#include "host/exchange/sample_table.hpp"

namespace roadbalance {

/// The samples of a WAV or RF64 file that `rb export` wrote: its comment tells channels, scales and the true
/// rate. Samples that were missing are silence there, and come back as that.
/// @throws ConfigError naming the file and what is allowed; std::system_error if it is not there
SampleTable read_wav_samples(const std::filesystem::path& file);

}  // namespace roadbalance
