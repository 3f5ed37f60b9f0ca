#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/bus/operation.hpp"
#include "common/record/disk.hpp"
#include "host/recorder/recorder.hpp"

namespace roadbalance {

/// Facts that all receipts of a recording share.
struct RecordingFacts {
  std::string name;
  std::int64_t incarnation = 0;
  std::int64_t began_us = 0;
  std::int64_t ended_us = 0;
  std::int64_t bytes = 0;
  std::int32_t marks = 0;
  std::map<std::int32_t, double> sync_us{};  ///< largest uncertainty of each node's clock
  std::string stopped_by{};                  ///< for people
};

/// One receipt a node, its epochs summed, also of one that never came though it should; one that names no
/// node if none was recorded.  An overload before a crash of the recorder is not in it.
std::vector<Receipt> receipts_of(const RecorderReport& report, const RecordingFacts& facts);

/// The receipts of a recording behind a run that fetched its rest.
/// @param before  at least one
/// @param report  of that run: what the folder held before it, too
std::vector<Receipt> completed(const std::vector<Receipt>& before, const RecorderReport& report,
                               std::int64_t bytes);

/// Sizes of the files in a folder; what cannot be read counts nothing.
std::int64_t bytes_of_folder(const std::filesystem::path& folder, Disk& disk = kernel_disk());

}  // namespace roadbalance
