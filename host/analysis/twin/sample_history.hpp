#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/dsp/fractional_delay.hpp"
#include "host/analysis/twin/sensor_samples.hpp"
#include "host/analysis/twin/twin_car.hpp"

namespace roadbalance {

/// The latest samples since the last restart, with what follows from them: the forces of unbalance and how
/// far either side of the car has rolled.
///
///     F_i = Re{U_i Om_i^2 r_i},  Om_i the rate of r_i's phase over kHalfRate samples to both sides, of
///                                those steps alone of which it is known
///
/// r_i has passed the filters that the accelerations passed, so F_i has, too.  A side has rolled by the mean
/// over its wheels of radius times angle; where none of them has its angle, by the other side's.
class SampleHistory {
 public:
  static constexpr int kHalfRate = 62;  ///< 0.25 s in all at 500 Hz: an encoder's errors of pitch average out
  static constexpr int kKept = 1024;    ///< samples at least, once so many have come
  using Drive = Eigen::Matrix<double, 2 * kWheels, 1>;  ///< z'' of the wheels [4], F [4]

  SampleHistory(const TwinChannels& channels, double rate_hz);

  void add(const SensorSample& sample, const TwinCar& car);
  void restart();

  std::int64_t oldest() const { return base_; }         ///< number of the oldest sample kept
  std::int64_t end() const { return base_ + filled_; }  ///< one after the newest's number
  /// One after the newest of which F is known.
  std::int64_t end_of_drive() const { return end() - kHalfRate; }

  std::int64_t time_ns(std::int64_t n) const { return time_ns_[place(n)]; }
  auto sensors(std::int64_t n) const { return values_.col(column(n)).head(sensors_); }
  auto wheels(std::int64_t n) const { return drive_.col(column(n)).template head<kWheels>(); }
  auto forces(std::int64_t n) const { return drive_.col(column(n)).template tail<kWheels>(); }
  /// True if at this sample any wheel's angle was known.
  bool rolls(std::int64_t n) const { return rolled_(2, column(n)) > 0.0; }
  double rolled_m(std::int64_t n, int side) const { return rolled_(side, column(n)); }
  /// Between samples; n + fraction needs FractionalDelay's samples on both sides.
  Drive drive_at(std::int64_t n, double fraction) const;

 private:
  Eigen::Index column(std::int64_t n) const { return static_cast<Eigen::Index>(n - base_); }
  std::size_t place(std::int64_t n) const { return static_cast<std::size_t>(n - base_); }
  void make_room();
  void roll(const TwinCar& car);
  void find_forces(const TwinCar& car);

  Eigen::MatrixXd wheels_from_;
  Eigen::Index sensors_;
  double rate_hz_;
  FractionalDelay delay_;
  std::int64_t base_ = 0;
  Eigen::Index filled_ = 0;
  Eigen::MatrixXd values_;
  Eigen::Matrix<double, 2 * kWheels, Eigen::Dynamic> drive_;
  Eigen::Matrix<double, kWheels, Eigen::Dynamic> angle_;  ///< rad, unwrapped while it is known
  Eigen::Matrix<double, kWheels, Eigen::Dynamic> steps_;  ///< from sample to sample that are in it
  Eigen::Matrix<double, 3, Eigen::Dynamic> rolled_;  ///< left, right, m; 1 if any wheel showed it, else 0
  std::vector<std::int64_t> time_ns_;
};

}  // namespace roadbalance
