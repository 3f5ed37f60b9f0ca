#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/record/disk.hpp"
#include "host/recording/transfer/digest.hpp"

namespace roadbalance {

/// The digests of a copy, in its folder, as `sha256sum -c` reads them.
inline constexpr const char* kDigestsFile = "sha256.txt";

struct TransferredFile {
  std::string name;
  std::uint64_t bytes = 0;
  Digest digest{};  ///< of the original, and of the copy as its disk gave it back
};

struct TransferReport {
  std::filesystem::path to;           ///< folder of the copy
  std::vector<TransferredFile> file;  ///< by name
  std::uint64_t bytes = 0;
  std::uint64_t resumed_bytes = 0;  ///< of these, left by an earlier transfer that did not end
  bool was_there = false;           ///< an equal copy was there already
};

/// Bytes done and to do; each counts when it is copied and when it is read back.
using TransferProgress = std::function<void(std::uint64_t done, std::uint64_t of)>;

/// Copies the recording `from` into the folder `to` under its own name, and reads the copy back.
///
/// Until all of it is proven the copy is called "<name>.part", so that a disk may be unplugged at any time:
/// the same call resumes there, keeping the bytes that compare equal.  The original is only read.
/// @throws std::runtime_error, std::system_error naming folder or file: no recording, one that is still being
/// written, no folder `to` (it is not made: its disk may not be mounted), no space, another recording of this
/// name there, a copy that differs when read back, stopped
TransferReport transfer(const std::filesystem::path& from, const std::filesystem::path& to,
                        const std::stop_token& stop, const TransferProgress& progress,
                        Disk& from_disk = kernel_disk(), Disk& to_disk = kernel_disk());

}  // namespace roadbalance
