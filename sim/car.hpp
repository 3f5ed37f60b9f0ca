#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "sim/drawn_car.hpp"
#include "sim/drive.hpp"
#include "sim/planar.hpp"
#include "sim/road.hpp"
#include "sim/vehicle.hpp"

namespace roadbalance::sim {

/// Everything a sensor of the car can feel, as one vector of kSources numbers: z'' [7], fore-and-aft and
/// sideways acceleration of the four wheel carriers [4 + 4], the car's own longitudinal acceleration [1],
/// m/s^2 or rad/s^2; then the road height under the four wheels [4], m.
enum Source : int {
  kCoordinateSource = 0,
  kForwardSource = kCoordinateSource + kCoordinates,
  kLeftSource = kForwardSource + kWheels,
  kDriveSource = kLeftSource + kWheels,
  kRoadSource = kDriveSource + 1,
  kSources = kRoadSource + kWheels,
};
using SourceVector = Eigen::Matrix<double, kSources, 1>;

/// The simulated car on its way: drive, road, wheels that turn and shake, the linear vehicle.
///
/// A pure function of (scenario, seed, vehicle, step): two cars built alike agree bit for bit.  It starts at
/// rest 8 s before bus time 0, at the first plateau's speed, so at time 0 it shakes as it will.
///
///     drive ──▶ angle ──▶ unbalance ──┐
///         └───▶ road ──▶ tyre force ──┴──▶ vehicle ──▶ z''
class Car {
 public:
  Car(const Scenario& scenario, std::uint64_t seed, const VehicleConfig& vehicle, double step_s);

  /// Advances one step.  Never allocates.
  void step();

  /// Bus time, s: 0 after construction.
  double time_s() const { return static_cast<double>(steps_) * step_s_; }
  std::int64_t steps() const { return steps_; }
  const SourceVector& sources() const { return sources_; }
  const Motion& motion() const { return motion_; }
  const Drive& drive() const { return drive_; }
  const DrawnCar& drawn() const { return drawn_; }

 private:
  struct Forces {
    WheelForces vertical;
    Array4 forward_n;
  };
  /// The car while its tyres' stiffness has not fallen further, bus time.
  struct Warmth {
    double until_s;
    double stiffness;  ///< as part of that of warm tyres
    VehicleDynamics dynamics;
  };
  static std::vector<Warmth> warm_up(const Scenario& scenario, const DrawnCar& car, double step_s);
  Forces wheel_forces();

  DrawnCar drawn_;
  double step_s_;
  std::int64_t steps_;
  Drive drive_;
  Motion motion_;
  std::array<RoadProfile, kWheels> road_;
  Array4 static_load_n_;
  std::vector<Warmth> warmth_;
  std::size_t now_ = 0;  ///< of warmth_
  PlanarMotion planar_;
  SourceVector sources_;
};

}  // namespace roadbalance::sim
