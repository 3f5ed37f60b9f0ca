#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/recording/formats/sample_source.hpp"
#include "tools/import/channel_units.hpp"
#include "tools/import/csv_samples.hpp"
#include "tools/import/sample_clock.hpp"
#include "tools/import/tachometer.hpp"

namespace roadbalance {

struct SampleImport {
  std::filesystem::path samples;
  std::optional<std::filesystem::path> pulses = {};
  /// Columns of samples whose signal gives the pulses instead.
  std::vector<TachometerColumn> tachometer = {};
  std::optional<std::filesystem::path> marks = {};
  std::filesystem::path folder;  ///< of the recording to make; must not hold anything yet, and appears whole
  OpenSamples open = open_csv_samples;  ///< of the format that `samples` is in
  UnitOptions units = {};
};

struct ImportReport {
  std::string sha256;                 ///< of the file of samples
  std::vector<ChannelUnit> channels;  ///< of each column
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
  struct Tachometer {
    std::string channel;
    int wheel;  ///< place in kWheelNames
    std::int64_t pulses;
    double threshold;      ///< in the column's unit
    double stamp_sigma_s;  ///< standard deviation of a pulse's instant
  };
  std::vector<Tachometer> tachometers;
  struct Node {
    std::string name;
    std::int32_t id;
    std::int64_t blocks, scans, scans_missing, edges;
  };
  std::vector<Node> nodes;
  std::size_t marks = 0;
  bool has_pulses = false;  ///< without, identification is not possible
};

/// Called with the share of all work that is done, 0 to 1.
using ImportProgress = std::function<void(double part)>;

/// Makes a recording from other programs' samples, through the same sealing as a node's.  Channels go by
/// their name to the node that vehicle.toml gives them; no sample is invented or moved to another channel.
/// Two channels of one name go by with_unique_names().  A column with a tachometer's signal becomes pulses
/// (TachometerPulses) on the uniform clock of the samples, and is no channel unless vehicle.toml has one of
/// its name. The same input gives the same record.  The files are gone through twice, first for their clock,
/// once more for the digest, and never held: memory does not grow with their length.
///
/// @throws ConfigError naming file, line, column or channel at fault: an unknown unit, a column for no
///         channel, a channel without column, a rate more than 1 % off rate_hz, a node without any sample, a
///         tachometer that is no column, does not change, or is of a wheel without encoder, a file that was
///         written to meanwhile; std::system_error for files; std::runtime_error if asked to
///         stop: then nothing is left
ImportReport import_samples(const SampleImport& import, const VehicleConfig& vehicle,
                            std::stop_token stop = {}, const ImportProgress& progress = {});

}  // namespace roadbalance
