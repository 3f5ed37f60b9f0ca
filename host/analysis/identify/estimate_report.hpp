#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/results.hpp"
#include "common/config/vehicle_config.hpp"
#include "host/analysis/identify/drive_groups.hpp"
#include "host/analysis/identify/estimate_covariance.hpp"
#include "host/analysis/identify/phase_drift.hpp"
#include "host/analysis/identify/posterior_car.hpp"
#include "host/analysis/identify/speed_classes.hpp"
#include "host/analysis/identify/speed_forces.hpp"

namespace roadbalance {

/// Fewer sections than this cannot show their own scatter.
inline constexpr int kLeastSections = 6;

struct DriveEstimate {
  Identification identification;
  std::array<Balance, kWheels> balance;
};

/// From the moments of a drive, or of several together, to the report on the car: the same for one that
/// goes on, one that is over, and many.
class EstimateReport {
 public:
  explicit EstimateReport(const VehicleConfig& vehicle);

  /// No estimate, and why.
  void unknown(Unknown state);
  /// From all that was driven until `time_ns`.
  /// @param car     the most probable one; nothing: none was found, or it is from the body alone
  /// @param drives  if it is several drives: they may differ by more than their sections scatter
  void draw(const SpeedClasses& drive, const std::optional<PosteriorCar>& car, const PhaseDrift& drift,
            std::int64_t time_ns, const DriveGroups& drives = {});

  const DriveEstimate& estimate() const { return estimate_; }
  /// Forces of the newest estimate; empty where it gives no balance, or none but from the body alone.
  const DriveForces& forces() const { return forces_; }
  /// EstimateCovariance::drives_ratio of it.
  const std::array<double, kWheels>& drives_ratio() const { return drives_ratio_; }
  const Priors& priors() const { return priors_; }
  /// No sensor sits on some wheel's carrier.
  bool body_only() const { return body_only_; }
  /// What is known of the car before it is driven; nothing: its sensors do not show every wheel.
  const std::optional<CarPrior>& prior() const { return prior_; }
  /// Why there can be no estimate whatever is driven; empty: nothing.
  const std::string& of_vehicle() const { return of_vehicle_; }
  /// The sensors do not determine what is asked for.
  void unfit(const std::string& why);
  const std::vector<std::string>& remarks() const {
    return remarks_;
  }  ///< on what it rests, and on deviations
  /// That and what the newest estimate was refused for.
  std::string refusal(const PhaseDrift& drift) const;

 private:
  void describe(const SpeedClasses& drive, const PhaseDrift& drift, std::int64_t time_ns);
  void draw_body(const SpeedClasses& drive, const PhaseDrift& drift, const DriveGroups& drives);
  /// @param widened  factor of each variance for drives that differ
  void publish(const PosteriorCar& car, const UnknownVector& widened);
  void publish_body(const UnknownVector& x, const EstimateCovariance& covariance, const PhaseDrift& drift);
  void add_variance_of_datum(Balance& balance) const;
  /// In the balances: what vehicle.toml may be wrong by, where the body alone was heard.
  void add_variance_of_parameters(const DriveMoments& drive);

  const VehicleConfig vehicle_;
  const Priors priors_;
  std::optional<CarPrior> prior_;
  const bool body_only_;
  std::string of_vehicle_;
  std::string refusal_;  ///< of the estimate; empty: it is given, or there is none yet
  std::vector<std::string> remarks_;
  DriveEstimate estimate_;
  DriveForces forces_{};
  std::array<double, kWheels> drives_ratio_{1.0, 1.0, 1.0, 1.0};
};

}  // namespace roadbalance
