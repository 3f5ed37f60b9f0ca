#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "host/exchange/sample_source.hpp"

namespace roadbalance {

/// What a process that reads a file for us may take.
struct ReaderLimits {
  /// Of a processor, for the file's opening; as much for kRowsAtOnce rows of each channel.
  int processor_s = 10;
  /// Without anything being told, whatever is waited for.
  int wait_s = 60;
  /// Of memory, beyond what this process has when it begins; 0: half the machine's.
  std::int64_t more_bytes = 0;
};

/// Samples that a process of its own reads: for a library that goes wrong where a file is damaged.  HDF5 1.10
/// reads beyond its memory, asks for all that the machine has, or never comes back; then that process ends,
/// and not this one.  It reads ahead by what a pipe holds; rewind() begins another.  Both fork: no other
/// thread may be at work then.
///
/// @throws what `open` or its source throws: ConfigError as it is, all else as std::runtime_error of the same
///         text; ConfigError naming the file if the process ended of itself or reached a limit;
///         std::system_error if there can be no process
std::unique_ptr<SampleSource> read_separately(const std::filesystem::path& file, OpenSamples open,
                                              ReaderLimits limits = {});

}  // namespace roadbalance
