#include "host/analysis/balance/overall_plan.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "common/vehicle/sensor_map.hpp"
#include "common/vehicle/unbalance_response.hpp"
#include "host/analysis/balance/compensate.hpp"
#include "host/analysis/balance/overall.hpp"
#include "host/analysis/balance/weight_plan.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using Weights = std::array<Complex, kWheels>;  ///< kg m

/// Vibration of a seat by a wheel at a speed.
struct Feeling {
  std::size_t speed, wheel;
  double weight;      ///< k
  double omega;       ///< rad/s
  Complex per_force;  ///< H, m/s^2 per N
  Complex measured;   ///< R, m/s^2
};

std::vector<Feeling> feelings(const DriveForces& drive, const Geometry& geometry,
                              const std::vector<SeatConfig>& seats) {
  const LinearModel model = linear_model(geometry, drive.parameters);
  std::vector<Feeling> all;
  for (std::size_t s = 0; s < drive.speed.size(); ++s)
    for (std::size_t w = 0; w < kWheels; ++w) {
      const FirstOrderForce& force = drive.speed[s].wheel[w];
      if (force.variance_n2 == 0.0) continue;
      const auto response = unbalance_response(model, static_cast<int>(w), force.omega);
      for (const SeatConfig& seat : seats) {
        const Complex here =
            response(0) + seat.position_m.y() * response(1) - seat.position_m.x() * response(2);
        const Complex per_force = here / (force.omega * force.omega);
        all.push_back(
            {s, w, seat.weight * drive.speed[s].seconds, force.omega, per_force, per_force * force.force_n});
      }
    }
  return all;
}

/// Best weight of one wheel: other wheels' frequencies are others.
Complex best_weight(const std::vector<Feeling>& felt, std::size_t wheel) {
  std::vector<ResponsePoint> points;
  for (const Feeling& f : felt)
    if (f.wheel == wheel)
      points.push_back({f.measured, Eigen::VectorXcd::Constant(1, f.per_force),
                        Eigen::VectorXd::Constant(1, f.omega), f.weight});
  const auto found = compensate_overall(points);
  return found ? found->correction_kg_m(0) : 0.0;
}

/// Its standard deviation by that of the forces, kg m.  Minus the best weight is
/// sum k |H|^2 Om^2 a / sum k |H|^2 Om^4; the seats share the force of a speed, a, speeds do not.
double best_weight_deviation(const std::vector<Feeling>& felt, const DriveForces& drive, std::size_t wheel) {
  std::vector<double> gain(drive.speed.size(), 0.0);
  double all = 0.0, variance = 0.0;
  for (const Feeling& f : felt)
    if (f.wheel == wheel) {
      const double share = f.weight * std::norm(f.per_force) * f.omega * f.omega;
      gain[f.speed] += share;
      all += share * f.omega * f.omega;
    }
  for (std::size_t s = 0; s < gain.size(); ++s)
    variance += gain[s] * gain[s] * 2.0 * drive.speed[s].wheel[wheel].variance_n2;
  return all > 0.0 ? std::sqrt(variance) / all : 0.0;
}

/// Rms at one speed, or over all: -1.
double rms(const std::vector<Feeling>& felt, int speed, const Weights& weights, double all_weights) {
  double sum = 0.0;
  for (const Feeling& f : felt)
    if (speed < 0 || f.speed == static_cast<std::size_t>(speed))
      sum += f.weight * 0.5 * std::norm(f.measured + f.per_force * f.omega * f.omega * weights[f.wheel]);
  return std::sqrt(sum / all_weights);
}

}  // namespace

std::vector<SeatConfig> seats_of(const VehicleConfig& vehicle) {
  if (!vehicle.seat.empty()) return vehicle.seat;
  std::vector<SeatConfig> seats;
  for (const SensorMap::Input& input : SensorMap::of_body(vehicle).input) {
    const ChannelConfig& channel =
        vehicle.node[static_cast<std::size_t>(input.node)].channel[static_cast<std::size_t>(input.channel)];
    seats.push_back({channel.name, channel.position_m});
  }
  return seats;
}

OverallPlan plan_overall(const DriveForces& drive, const VehicleConfig& vehicle,
                         const std::array<Compensation, kWheels>& by_wheel) {
  OverallPlan result;
  result.seat = seats_of(vehicle);
  const std::vector<Feeling> felt = feelings(drive, geometry_of(vehicle.model), result.seat);
  constexpr double kKilogram = 1e-3;
  Weights each{}, best{}, bought{};
  for (std::size_t w = 0; w < kWheels; ++w) {
    OverallPlan::Wheel& wheel = result.wheel[w];
    wheel.plan = by_wheel[w].plan;
    wheel.radii = by_wheel[w].radii;
    const bool is_felt = std::ranges::any_of(felt, [&](const Feeling& f) { return f.wheel == w; });
    if (is_felt && (by_wheel[w].advice == Advice::kSteps || by_wheel[w].advice == Advice::kLeaveSmall)) {
      best[w] = best_weight(felt, w);
      const WheelConfig& config = vehicle.wheel[w];
      wheel.best = {std::abs(best[w]) / (kKilogram * config.weight_radius_m),
                    std::arg(best[w]),
                    {.radius_m = config.weight_radius_m}};
      wheel.plan = plan_weights(-best[w] / kKilogram, best_weight_deviation(felt, drive, w) / kKilogram,
                                config.stock, config.fitted);
    }
    each[w] = kKilogram * by_wheel[w].plan.applied_g_m;
    bought[w] = kKilogram * wheel.plan.applied_g_m;
  }
  double seats = 0.0, seconds = 0.0;
  for (const SeatConfig& seat : result.seat) seats += seat.weight;
  const auto vibration = [&](int speed, double driven_s) {
    const double all = seats * driven_s;
    return SeatVibration{rms(felt, speed, {}, all), rms(felt, speed, each, all),
                         rms(felt, speed, bought, all), rms(felt, speed, best, all)};
  };
  for (std::size_t s = 0; s < drive.speed.size(); ++s) {
    const SpeedForces& speed = drive.speed[s];
    seconds += speed.seconds;
    result.speed.push_back({speed.speed_m_s, speed.seconds, vibration(static_cast<int>(s), speed.seconds)});
    for (std::size_t w = 0; w < kWheels; ++w)
      result.speed.back().without_force[w] = speed.wheel[w].variance_n2 == 0.0;
  }
  if (seconds > 0.0) result.vibration = vibration(-1, seconds);
  return result;
}

std::array<WheelVibration, kWheels> wheel_vibration(const DriveForces& drive, const VehicleConfig& vehicle,
                                                    const std::array<Compensation, kWheels>& by_wheel) {
  const std::vector<SeatConfig> seats = seats_of(vehicle);
  double all = 0.0;
  for (const SeatConfig& seat : seats) all += seat.weight;
  double seconds = 0.0;
  for (const SpeedForces& speed : drive.speed) seconds += speed.seconds;
  const std::vector<Feeling> felt = feelings(drive, geometry_of(vehicle.model), seats);
  constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
  std::array<WheelVibration, kWheels> result;
  for (std::size_t w = 0; w < kWheels; ++w) {
    std::vector<Feeling> of_wheel;
    std::ranges::copy_if(felt, std::back_inserter(of_wheel), [&](const Feeling& f) { return f.wheel == w; });
    Weights steps{};
    steps[w] = 1e-3 * by_wheel[w].plan.applied_g_m;
    result[w] = {kNotKnown, kNotKnown};
    if (!of_wheel.empty())
      result[w] = {rms(of_wheel, -1, {}, all * seconds), rms(of_wheel, -1, steps, all * seconds)};
  }
  return result;
}

std::array<Compensation, kWheels> compensate_all(const std::array<Balance, kWheels>& balance,
                                                 const DriveForces& drive, const VehicleConfig& vehicle) {
  std::array<Compensation, kWheels> result;
  for (std::size_t w = 0; w < kWheels; ++w)
    result[w] = compensate(balance[w], vehicle.wheel[w], vehicle.limits);
  if (drive.speed.empty()) return result;
  const auto vibration = wheel_vibration(drive, vehicle, result);
  for (std::size_t w = 0; w < kWheels; ++w) {
    result[w].seat_now_m_s2 = vibration[w].now;
    result[w].seat_left_m_s2 = vibration[w].left;
  }
  return result;
}

}  // namespace roadbalance
