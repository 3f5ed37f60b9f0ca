#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "host/recording/formats/sample_source.hpp"

namespace roadbalance {

/// Limits of the process that reads a file for us.
struct ReaderLimits {
  /// Processor time to open the file; the same again for each kRowsAtOnce rows of each channel.
  int processor_s = 10;
  /// Longest wait for a message, whatever the process waits for.
  int wait_s = 60;
  /// Memory, beyond that of this process when the other one begins; 0: half the machine's.
  std::int64_t more_bytes = 0;
};

/// Samples that a separate process reads, for a library that fails on damaged files.  HDF5 1.10 reads beyond
/// its memory, asks for all of the machine's, or never returns; then that process ends, and not this one.  It
/// reads ahead by the size of a pipe; rewind() begins another process.  Opening and rewind() fork: no other
/// thread may be running then.
///
/// @throws the exceptions of `open` and its source: ConfigError as it is, any other as std::runtime_error of
/// the
///         same text; ConfigError naming the file if the process ended by itself or reached a limit;
///         std::system_error if no process can be made
std::unique_ptr<SampleSource> read_separately(const std::filesystem::path& file, OpenSamples open,
                                              ReaderLimits limits = {});

}  // namespace roadbalance
