#include "tools/study/ideal_drive.hpp"

#include <cmath>
#include <complex>
#include <stdexcept>

#include "common/dsp/decimation.hpp"
#include "common/vehicle/sensor_map.hpp"
#include "sim/car.hpp"
#include "sim/random.hpp"

namespace roadbalance {
namespace {

constexpr int kStepsInSample = 4;  ///< of the car in a sample
constexpr double kIdealRamp_s = 2.0;
constexpr double kIdealSettling_s = 3.0;

/// Everything a stretch may hold, one column an instant.
constexpr int kRows = kSignals + kWheels;
using SampleColumn = Eigen::Matrix<double, kRows, 1>;

sim::DriveScenario plateaus(const IdealDrive& drive) {
  const double seconds = kIdealRamp_s + kIdealSettling_s +
                         static_cast<double>(drive.samples + kStepsInSample) / drive.rate_hz + 1.0;
  sim::DriveScenario result{.plateau = {}, .ramp_s = kIdealRamp_s, .wander_m_s = 0.0};
  for (const double speed_m_s : drive.speeds_m_s) result.plateau.push_back({speed_m_s, seconds});
  return result;
}

SampleColumn observe(const sim::Car& car) {
  SampleColumn column;
  column.head<kCoordinates>() = car.sources().segment<kCoordinates>(sim::kCoordinateSource);
  const sim::DrawnCar& drawn = car.drawn();
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    const double angle = car.motion().position_m / drawn.rolling_radius_m[w] + drawn.initial_angle_rad[w];
    column(cosine_row(i)) = std::cos(angle);
    column(sine_row(i)) = std::sin(angle);
  }
  column.tail<kWheels>() = car.sources().segment<kWheels>(sim::kRoadSource);
  return column;
}

std::vector<Stretch> drive_each_speed(const IdealDrive& drive, std::uint64_t seed,
                                      const VehicleConfig& vehicle) {
  if (drive.scenario.parameter_spread != 0.0 || drive.scenario.rolling_radius_spread != 0.0)
    throw std::invalid_argument("angles drawn at each speed need a car of which nothing else is drawn");
  const sim::RandomSequence seeds(seed, sim::Use::kInitialAngle, 1);  // 0 is the car's own
  std::vector<Stretch> stretches;
  for (std::size_t k = 0; k < drive.speeds_m_s.size(); ++k) {
    IdealDrive one = drive;
    one.speeds_m_s = {drive.speeds_m_s[k]};
    one.angles_drawn_at_each_speed = false;
    stretches.push_back(drive_ideally(one, seeds.bits(static_cast<std::int64_t>(k)), vehicle).front());
  }
  return stretches;
}

}  // namespace

std::vector<Stretch> drive_ideally(const IdealDrive& drive, std::uint64_t seed,
                                   const VehicleConfig& vehicle) {
  if (drive.angles_drawn_at_each_speed) return drive_each_speed(drive, seed, vehicle);
  sim::Scenario scenario = drive.scenario;
  scenario.drive = plateaus(drive);
  const double step_s = 1.0 / (kStepsInSample * drive.rate_hz);
  sim::Car car(scenario, seed, vehicle, step_s);
  const Eigen::VectorXd taps = decimation_taps(kStepsInSample);
  const Eigen::MatrixXd sensors = SensorMap::from(vehicle).readings;

  std::vector<Stretch> stretches;
  double begin_s = 0.0;
  for (const sim::Plateau& plateau : scenario.drive.plateau) {
    while (car.time_s() < begin_s + kIdealRamp_s + kIdealSettling_s) car.step();
    Eigen::Matrix<double, kRows, Eigen::Dynamic> fine(kRows,
                                                      kStepsInSample * (drive.samples - 1) + taps.size());
    for (Eigen::Index k = 0; k < fine.cols(); ++k, car.step()) fine.col(k) = observe(car);

    Stretch stretch;
    stretch.rate_hz = drive.rate_hz;
    stretch.speed_m_s = plateau.speed_m_s;
    for (int i = 0; i < kWheels; ++i)
      stretch.omega(i) = vehicle.wheel[static_cast<std::size_t>(i)].node.empty()
                             ? 0.0
                             : plateau.speed_m_s / car.drawn().rolling_radius_m[static_cast<std::size_t>(i)];
    stretch.signals.resize(kSignals, drive.samples);
    if (drive.road_measured) stretch.road_m.resize(kWheels, drive.samples);
    for (Eigen::Index k = 0; k < drive.samples; ++k) {
      const SampleColumn sample = fine.middleCols(kStepsInSample * k, taps.size()) * taps;
      stretch.signals.col(k) = sample.head<kSignals>();
      if (drive.road_measured) stretch.road_m.col(k) = sample.tail<kWheels>();
    }
    stretch.readings = sensors * stretch.signals.topRows<kCoordinates>();
    stretches.push_back(std::move(stretch));
    begin_s += plateau.seconds;
  }
  return stretches;
}

}  // namespace roadbalance
