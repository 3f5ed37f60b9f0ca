#include "sim/car.hpp"

#include <cmath>
#include <complex>

namespace roadbalance::sim {
namespace {

constexpr double kRunIn_s = 8.0;  ///< the slowest mode, 1.2 Hz with D = 0.2, decays by e^-12
constexpr double kGravity_m_s2 = 9.81;
constexpr double kScrub = 0.1;  ///< sideways force on a carrier per vertical force of inertia

std::array<RoadProfile, kWheels> make_road(const Scenario& scenario, std::uint64_t seed,
                                           const Geometry& geometry, double start_m) {
  const auto profile = [&](std::size_t wheel) {
    return RoadProfile(scenario.road, seed, wheel, start_m + geometry.x_m[wheel]);
  };
  return {profile(0), profile(1), profile(2), profile(3)};
}

/// Weight on each wheel at standstill.
Array4 static_load(const DrawnCar& car) {
  Array4 load_n;
  const double wheelbase_m = car.geometry.x_m[0] - car.geometry.x_m[2];
  for (int i = 0; i < kWheels; ++i) {
    const double other_axle_m = car.geometry.x_m[i < 2 ? 2 : 0];
    const double share = 0.5 * std::abs(other_axle_m) / wheelbase_m;
    load_n(i) = kGravity_m_s2 * (share * car.parameters(kBodyMass) + car.parameters(kWheelMass + i));
  }
  return load_n;
}

}  // namespace

Car::Car(const Scenario& scenario, std::uint64_t seed, const VehicleConfig& vehicle, double step_s)
    : drawn_(draw_car(scenario, seed, vehicle)),
      step_s_(step_s),
      steps_(-std::llround(kRunIn_s / step_s)),
      drive_(scenario.drive, seed),
      motion_(drive_.at(time_s())),
      road_(make_road(scenario, seed, drawn_.geometry, motion_.position_m)),
      static_load_n_(static_load(drawn_)),
      dynamics_(linear_model(drawn_.geometry, drawn_.parameters),
                Dampers(scenario.damper, drawn_.geometry, drawn_.parameters), step_s),
      planar_(drawn_.parameters, step_s),
      sources_(SourceVector::Zero()) {
  dynamics_.reset(wheel_forces().vertical);
  while (steps_ < 0) step();
}

Car::Forces Car::wheel_forces() {
  Forces forces;
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    const RoadPoint road = road_[w].at(motion_.position_m + drawn_.geometry.x_m[w]);
    const double tyre_n_m = drawn_.parameters(kTyre + i);
    const double tyre_n_s_m = drawn_.parameters(kTyreDamper + i);
    const double lift_m_s = road.slope * motion_.speed_m_s;
    const double lift_m_s2 =
        road.curvature_1_m * motion_.speed_m_s * motion_.speed_m_s + road.slope * motion_.acceleration_m_s2;
    const double radius_m = drawn_.rolling_radius_m[w];
    const double omega = motion_.speed_m_s / radius_m;
    const double omega_rate = motion_.acceleration_m_s2 / radius_m;
    // F = (U Om^2 + R) e^{j alpha}, F' = (2 U Om Om' + j Om (U Om^2 + R)) e^{j alpha}   (conventions.md)
    const std::complex<double> turn =
        std::polar(1.0, motion_.position_m / radius_m + drawn_.initial_angle_rad[w]);
    const std::complex<double> unbalance = drawn_.wheel[w].unbalance_kg_m * turn;
    const std::complex<double> centrifugal = unbalance * (omega * omega);
    const std::complex<double> first_order = centrifugal + drawn_.wheel[w].radial_force_n * turn;
    forces.vertical.force_n(i) = tyre_n_m * road.height_m + tyre_n_s_m * lift_m_s + first_order.real();
    forces.vertical.rate_n_s(i) = tyre_n_m * lift_m_s + tyre_n_s_m * lift_m_s2 +
                                  2.0 * omega * omega_rate * unbalance.real() - omega * first_order.imag();
    // At the front of its turn (a quarter ahead of the upward vertical) the heavy spot pulls forward.
    forces.forward_n(i) = centrifugal.imag() - static_load_n_(i) * road.slope;
    sources_(kRoadSource + i) = road.height_m;
  }
  return forces;
}

void Car::step() {
  ++steps_;
  motion_ = drive_.at(time_s());
  const Forces forces = wheel_forces();
  dynamics_.step(forces.vertical);
  const Vector7& acceleration = dynamics_.acceleration();
  const Array4 left_n =
      kScrub * drawn_.parameters.segment<kWheels>(kWheelMass).array() * acceleration.tail<kWheels>().array();
  planar_.step(forces.forward_n, left_n);
  sources_.segment<kCoordinates>(kCoordinateSource) = acceleration;
  sources_.segment<kWheels>(kForwardSource) = planar_.forward_m_s2().matrix();
  sources_.segment<kWheels>(kLeftSource) = planar_.left_m_s2().matrix();
  sources_(kDriveSource) = motion_.acceleration_m_s2;
}

}  // namespace roadbalance::sim
