#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "common/test/source.hpp"
#include "common/vehicle/sensor_map.hpp"
#include "host/analysis/identify/estimate_covariance.hpp"
#include "host/analysis/identify/section.hpp"
#include "host/analysis/identify/speed_classes.hpp"
#include "tools/study/ideal_drive.hpp"

namespace roadbalance::test {

/// The demonstration car.
inline const VehicleConfig& demo_car() {
  static const VehicleConfig vehicle = VehicleConfig::read_file(source_path("sim/demo/vehicle.toml"));
  return vehicle;
}

/// Plateaus of the demonstration scenario's car on its road, parameters drawn within 10 %, with four wheels
/// out of balance.
inline IdealDrive plateaus(const std::vector<double>& km_h, int seconds) {
  IdealDrive drive{
      .scenario = sim::Scenario::read("", demo_car()), .speeds_m_s = {}, .samples = seconds * 500};
  for (const double speed : km_h) drive.speeds_m_s.push_back(speed / 3.6);
  return drive;
}

/// The moments of a drive of the demonstration car as the product gathers them, weights learnt on the way.
/// @param described   what identification takes the car for
/// @param noise_m_s2  white, on each coordinate
inline SpeedClasses gather(const IdealDrive& drive, std::uint64_t seed, const VehicleConfig& described,
                           double noise_m_s2 = 0.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, noise_m_s2);
  SpeedClasses classes(described.drive.speed_class_m_s);
  const Priors known = Priors::of(described);
  const Eigen::MatrixXd sensors = SensorMap::from(described).readings;
  ParameterVector weights = known.value;
  for (Stretch& stretch : drive_ideally(drive, seed, demo_car())) {
    if (noise_m_s2 > 0.0)
      for (double& value : stretch.signals.topRows<kCoordinates>().reshaped()) value += normal(random);
    SectionBuilder sections(
        described, [&](const DriveMoments& section) { classes.add(section); }, sensors);
    sections.set_parameters(weights);
    for (Eigen::Index k = 0; k < stretch.signals.cols(); ++k)
      sections.consume({.signals = stretch.signals.col(k),
                        .readings = sensors * stretch.signals.col(k).head<kCoordinates>(),
                        .restart = k == 0});
    if (const auto running = sections.running()) classes.add(*running);
    if (const auto x = solve(classes.total(), known.geometry, known.value))
      weights.segment<kEstimatedUnbalance>(kSpring) = x->head<kEstimatedUnbalance>();
  }
  return classes;
}

}  // namespace roadbalance::test
