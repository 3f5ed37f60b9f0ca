#pragma once

#include <array>
#include <complex>
#include <cstdint>

#include <Eigen/Core>

#include "common/vehicle/linear_model.hpp"

namespace roadbalance {

/// Signals of identification, a column a sample: rows 0..6 the accelerations z'' of the seven
/// coordinates in SI units, rows 7 + 2 i and 8 + 2 i cos and sin of wheel i's angle, all having passed the
/// same filters.
inline constexpr int kSignals = kCoordinates + 2 * kWheels;
using SignalVector = Eigen::Matrix<double, kSignals, 1>;
using SignalMatrix = Eigen::Matrix<double, kSignals, Eigen::Dynamic>;

/// The literature's j.
inline constexpr std::complex<double> kJ(0.0, 1.0);

/// Height under the four wheels, m, a column a sample.
using RoadMatrix = Eigen::Matrix<double, kWheels, Eigen::Dynamic>;

constexpr int cosine_row(int wheel) {
  return kCoordinates + 2 * wheel;
}
constexpr int sine_row(int wheel) {
  return cosine_row(wheel) + 1;
}

/// Reference r = e^{j alpha} of wheel i in a signal vector.
template <typename Vector>
std::complex<double> reference(const Vector& signals, int wheel) {
  return {signals(cosine_row(wheel)), signals(sine_row(wheel))};
}

/// Consecutive samples on the grid that all nodes share.
struct SignalRun {
  std::int64_t first_index = 0;  ///< of column 0 on the grid
  bool restart = false;          ///< samples are missing before column 0: filters begin anew
  bool spoiled = false;          ///< nor are those before them good, since the last restart
  std::int64_t time_ns = 0;      ///< node time of the last column
  SignalMatrix samples;
  /// Of each of SensorMap's inputs, m/s^2, a column a sample; the same filters passed.
  Eigen::MatrixXd readings{};
  /// The same filters passed; no columns: the road was not measured.
  RoadMatrix road_m{};
};

}  // namespace roadbalance
