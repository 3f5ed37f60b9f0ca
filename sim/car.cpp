#include "sim/car.hpp"

#include <cmath>
#include <complex>
#include <limits>

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

/// The stiffness of tyres falls in steps so small: in each the car is linear.
constexpr double kWarmthStep = 0.002;

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
      warmth_(warm_up(scenario, drawn_, step_s)),
      planar_(drawn_.parameters, scenario.forward_hz, step_s),
      sources_(SourceVector::Zero()) {
  warmth_.front().dynamics.reset(wheel_forces().vertical);
  while (steps_ < 0) step();
}

std::vector<Car::Warmth> Car::warm_up(const Scenario& scenario, const DrawnCar& car, double step_s) {
  const TyreScenario& tyre = scenario.tyre;
  const Dampers dampers(scenario.damper, car.geometry, car.parameters);
  const auto steps = static_cast<int>(std::ceil(tyre.warming / kWarmthStep));
  std::vector<Warmth> warmth;
  for (int k = steps; k >= 0; --k) {
    const double more = steps > 0 ? tyre.warming * k / steps : 0.0;
    // more = warming e^(-t / warming_s), from half a step above to half a step below.
    const double until_s =
        k > 0 ? -tyre.warming_s * std::log((k - 0.5) / steps) : std::numeric_limits<double>::infinity();
    ParameterVector parameters = car.parameters;
    parameters.segment<kWheels>(kTyre) *= 1.0 + more;
    warmth.push_back({until_s, 1.0 + more, {linear_model(car.geometry, parameters), dampers, step_s}});
  }
  return warmth;
}

Car::Forces Car::wheel_forces() {
  Forces forces;
  const double warmth = warmth_[now_].stiffness;
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    const RoadPoint road = road_[w].at(motion_.position_m + drawn_.geometry.x_m[w]);
    const double tyre_n_m = warmth * drawn_.parameters(kTyre + i);
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
    const std::complex<double> first_order = centrifugal + warmth * drawn_.wheel[w].radial_force_n * turn;
    const std::complex<double> second_order = warmth * drawn_.wheel[w].higher_radial_force_n[0] * turn * turn;
    const std::complex<double> third_order =
        warmth * drawn_.wheel[w].higher_radial_force_n[1] * turn * turn * turn;
    forces.vertical.force_n(i) = tyre_n_m * road.height_m + tyre_n_s_m * lift_m_s + first_order.real() +
                                 second_order.real() + third_order.real();
    forces.vertical.rate_n_s(i) =
        tyre_n_m * lift_m_s + tyre_n_s_m * lift_m_s2 + 2.0 * omega * omega_rate * unbalance.real() -
        omega * (first_order.imag() + 2.0 * second_order.imag() + 3.0 * third_order.imag());
    // At the front of its turn (a quarter ahead of the upward vertical) the heavy spot pulls forward.
    forces.forward_n(i) = centrifugal.imag() - static_load_n_(i) * road.slope;
    sources_(kRoadSource + i) = road.height_m;
  }
  return forces;
}

void Car::step() {
  ++steps_;
  motion_ = drive_.at(time_s());
  if (time_s() >= warmth_[now_].until_s) {
    warmth_[now_ + 1].dynamics.go_on_from(warmth_[now_].dynamics);
    ++now_;
  }
  VehicleDynamics& dynamics = warmth_[now_].dynamics;
  const Forces forces = wheel_forces();
  dynamics.step(forces.vertical);
  const Vector7& acceleration = dynamics.acceleration();
  const Array4 left_n =
      kScrub * drawn_.parameters.segment<kWheels>(kWheelMass).array() * acceleration.tail<kWheels>().array();
  planar_.step(forces.forward_n, left_n);
  sources_.segment<kCoordinates>(kCoordinateSource) = acceleration;
  sources_.segment<kWheels>(kForwardSource) = planar_.forward_m_s2().matrix();
  sources_.segment<kWheels>(kLeftSource) = planar_.left_m_s2().matrix();
  sources_(kDriveSource) = motion_.acceleration_m_s2;
}

}  // namespace roadbalance::sim
