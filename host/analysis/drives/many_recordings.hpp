#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/drives/drive_share.hpp"
#include "host/analysis/drives/identify_record.hpp"
#include "host/analysis/identify/joint_drives.hpp"

namespace roadbalance {

/// A recording is not usable, and was not to be left out.
struct Unusable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One estimate from many recordings of one car, whose shares come one by one in the order of recordings().
class ManyRecordings {
 public:
  struct Used {
    std::filesystem::path recording;
    double seconds;
    int sections;
    std::int64_t missing_blocks;
  };
  struct LeftOut {
    std::filesystem::path recording;
    std::string why;
  };

  /// Reads what car each is of.
  /// @param recordings     in order
  /// @param skip_unusable  leave out what is not usable
  /// @throws ConfigError naming key and both recordings if two do not belong together; Unusable;
  ///         std::runtime_error if one cannot be read
  ManyRecordings(const std::vector<std::filesystem::path>& recordings, bool skip_unusable);

  /// Recordings whose share is wanted.
  const std::vector<std::filesystem::path>& recordings() const { return recordings_; }

  /// @throws ConfigError naming both if it holds samples of another; Unusable; std::runtime_error
  void take(const std::filesystem::path& recording, DriveShare share);

  /// From all that was taken, by the vehicle.toml of the last: limits, stock and seats may differ.
  RecordedEstimate estimate();

  const std::vector<Used>& used() const { return used_; }
  const std::vector<LeftOut>& left_out() const { return left_out_; }

 private:
  void leave_out(const std::filesystem::path& recording, const std::string& why, bool not_read);
  void refuse_shared_samples(const std::filesystem::path& recording,
                             const std::vector<MeasuredTime>& measured);

  struct Held {
    std::filesystem::path recording;
    std::vector<MeasuredTime> measured;
  };
  bool skip_unusable_;
  std::vector<std::filesystem::path> recordings_;
  std::optional<VehicleConfig> vehicle_;
  std::optional<JointDrives> drives_;
  std::vector<Used> used_;
  std::vector<LeftOut> left_out_;
  std::vector<Held> held_;
  std::string contradictions_;
};

}  // namespace roadbalance
