#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "host/analysis/identify/test/reference_car.hpp"
#include "host/analysis/twin/sensor_samples.hpp"
#include "host/analysis/twin/twin_motion.hpp"

namespace roadbalance::test {

using Complex = std::complex<double>;

/// Phasors of z'' by (1) as a whole: road heights in m, forces on the wheels in N.
inline Eigen::Matrix<Complex, kCoordinates, 1> acceleration(const LinearModel& model, double omega,
                                                            const Eigen::Vector4cd& road,
                                                            const Eigen::Vector4cd& force) {
  const Complex s(0.0, omega);
  const Eigen::Matrix<Complex, 7, 7> D = s * s * model.M + s * model.P + model.Q;
  return s * s * D.partialPivLu().solve((model.S + s * model.Sd) * road + model.W * force);
}

/// One frequency of a drive.
struct Line {
  double omega;
  Eigen::Vector4cd force;
  Eigen::Matrix<Complex, kCoordinates, 1> z;
};

/// Inputs of axle_motion at one frequency if the rear is `delay_s` behind the front.
inline Eigen::VectorXcd axle_inputs(const Line& line, int axle, double delay_s) {
  const Complex then = std::polar(1.0, (axle == 1 ? -1.0 : 1.0) * line.omega * delay_s);
  const int own = 2 * axle, other = 2 * (1 - axle);
  Eigen::VectorXcd u(kAxleInputs);
  u.segment<2>(kOtherNow) = line.z.segment<2>(kBodyCoordinates + other);
  u.segment<4>(kWheelsThen) = line.z.tail<4>() * then;
  u.segment<2>(kOtherForceThen) = line.force.segment<2>(other) * then;
  u.segment<2>(kForceNow) = line.force.segment<2>(own);
  return u;
}

/// A steady drive in closed form over a road of single frequencies on which the rear wheels follow the front
/// ones exactly, left and right each on its own; all wheels turn in step.  All frequencies are multiples of
/// 0.25 Hz, so that over 4 s they do not mix.
class KnownDrive {
 public:
  static constexpr double kRadius_m = 0.30, kRate_hz = 500.0,
                          kSpeed_m_s = 2.0 * std::numbers::pi * 16.75 * kRadius_m;

  explicit KnownDrive(const ParameterVector& car, double highest_hz = 30.0) {
    const LinearModel model = linear_model(kReferenceGeometry, car);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> phase(-std::numbers::pi, std::numbers::pi);
    for (double f = 0.75; f < highest_hz; f = std::max(f + 0.25, std::round(f * 1.13 * 4.0) / 4.0)) {
      if (f == 16.75) continue;
      const double omega = 2.0 * std::numbers::pi * f;
      const Complex left = std::polar(2e-3 / f, phase(random)), right = std::polar(2e-3 / f, phase(random));
      const Complex later = std::polar(1.0, -omega * delay_s());
      const Eigen::Vector4cd road(left, right, left * later, right * later);
      line.push_back({omega, Eigen::Vector4cd::Zero(), acceleration(model, omega, road, {0, 0, 0, 0})});
    }
    const double turning = kSpeed_m_s / kRadius_m;
    Eigen::Vector4cd force;
    for (std::size_t w = 0; w < kWheels; ++w)
      force(static_cast<Eigen::Index>(w)) = kReferenceUnbalance[w] * turning * turning * angle(w, 0.0);
    line.push_back({turning, force, acceleration(model, turning, {0, 0, 0, 0}, force)});
  }

  static double delay_s() { return (kReferenceGeometry.x_m[0] - kReferenceGeometry.x_m[2]) / kSpeed_m_s; }
  static Complex angle(std::size_t wheel, double time_s) {
    return std::polar(1.0, kSpeed_m_s / kRadius_m * time_s + 0.7 * static_cast<double>(wheel));
  }

  Vector7 at(double time_s) const {
    Vector7 z = Vector7::Zero();
    for (const Line& one : line) z += (one.z * std::polar(1.0, one.omega * time_s)).real();
    return z;
  }

  SensorSample sample(const TwinChannels& channels, int k) const {
    const double time_s = k / kRate_hz;
    SensorSample sample{.time_ns = std::llround(time_s * 1e9), .restart = k == 0, .values = {}};
    const auto n = static_cast<Eigen::Index>(channels.channel.size());
    sample.values.resize(n + 2 * kWheels);
    sample.values.head(n) = channels.from_coordinates * at(time_s);
    for (std::size_t w = 0; w < kWheels; ++w) {
      sample.values(n + 2 * static_cast<Eigen::Index>(w)) = angle(w, time_s).real();
      sample.values(n + 2 * static_cast<Eigen::Index>(w) + 1) = angle(w, time_s).imag();
    }
    return sample;
  }

  std::vector<Line> line;
};

}  // namespace roadbalance::test
