#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/config/vehicle_config.hpp"
#include "host/analysis/identify/drive_groups.hpp"
#include "host/analysis/identify/drive_sums.hpp"
#include "host/analysis/identify/estimate_report.hpp"

namespace roadbalance {

/// How drives are put together.  The product does both; what each is worth, `rb study many-drives` measures.
struct Joining {
  bool by_road = true;  ///< suspension and tyres: every drive divided by what its road shakes
  bool widened = true;  ///< the covariance, where drives differ by more than their sections scatter
};

/// One estimate from many drives of one car: their moments add.
///
/// Springs, dampers, stabilisers, tyres and unbalances are taken to be the same in all drives; by how much
/// drives differ beyond what their sections scatter, a warm tyre for one, is in the covariance
/// (estimate_covariance.hpp).  The equations of suspension and tyres grow with the square of what the road
/// shakes: each drive's are divided by its own, so that a drive counts by its length and a rough road does
/// not decide alone.  Those of the unbalances carry weights of their own road already.
///
/// The result depends on the order of the drives in its last bits.
class JointDrives {
 public:
  explicit JointDrives(const VehicleConfig& vehicle, Joining joining = {})
      : joining_(joining), report_(vehicle), classes_(vehicle.drive.speed_class_m_s) {}

  void add(DriveSums drive);

  /// @return the estimate from all that was added
  const DriveEstimate& estimate();
  const DriveForces& forces() const { return report_.forces(); }
  std::string refusal() const { return report_.refusal(drift_); }
  /// Wheels whose unbalance differs between drives by more than chance, one in a thousand: for people.
  std::vector<std::string> diagnostics() const;
  /// EstimateCovariance::drives_ratio of the newest estimate.
  const std::array<double, kWheels>& drives_ratio() const { return report_.drives_ratio(); }
  /// The greatest of the drives'.
  const std::array<double, kWheels>& common_sigma_rad() const { return common_sigma_rad_; }

 private:
  Joining joining_;
  EstimateReport report_;
  SpeedClasses classes_;
  DriveGroups drives_;
  std::vector<PosteriorSums> roads_;  ///< of drives, dealt out in turn
  std::size_t added_ = 0;
  PhaseDrift drift_;
  std::int64_t time_ns_ = 0;
  std::array<double, kWheels> common_sigma_rad_{};
};

}  // namespace roadbalance
