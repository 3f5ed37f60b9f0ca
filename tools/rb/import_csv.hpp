#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "tools/rb/csv_table.hpp"
#include "tools/rb/sample_clock.hpp"

namespace roadbalance {

/// What reads a file of samples; errors as read_samples() has them.
using ReadSamples = std::function<SampleTable(const std::filesystem::path& file)>;

struct CsvImport {
  std::filesystem::path samples;
  std::optional<std::filesystem::path> pulses = {};
  std::optional<std::filesystem::path> marks = {};
  std::filesystem::path folder;  ///< of the recording to make; must not hold anything yet, and appears whole
  ReadSamples read = read_samples;  ///< of the format that `samples` is in
};

struct CsvImportReport {
  std::int64_t rows = 0;
  double seconds = 0.0;
  double rate_hz = 0.0;                         ///< fitted; the samples are stored at this uniform rate
  double stamp_rms_s = 0.0, stamp_max_s = 0.0;  ///< how far the stamps were from it
  std::vector<SampleClock::Hole> holes;         ///< declared as gaps
  struct Suspicion {
    std::string channel;
    std::string what;  ///< a clause in English: "sits at -4.3 g on average"
  };
  std::vector<Suspicion> suspicions;
  struct Node {
    std::string name;
    std::int32_t id;
    std::int64_t blocks, scans, scans_missing, edges;
  };
  std::vector<Node> nodes;
  std::size_t marks = 0;
  bool has_pulses = false;  ///< without, identification is not possible
};

/// Makes a recording from somebody else's samples, through the same sealing as a node's.  Channels go by
/// their name to the node that vehicle.toml gives them; no sample is invented or moved to another channel.
/// The same input gives the same record.
///
/// @throws ConfigError naming file, line, column or channel at fault: an unknown unit, a column no channel
///         wants, a channel without column, a rate more than 1 % off rate_hz; std::system_error for files
CsvImportReport import_csv(const CsvImport& import, const VehicleConfig& vehicle);

}  // namespace roadbalance
