#include "host/analysis/identify/line_moments.hpp"

namespace roadbalance {

LineMoments& LineMoments::operator+=(const LineMoments& other) {
  if (other.seconds == 0.0) return *this;
  if (seconds == 0.0) return *this = other;
  normal += other.normal;
  for (std::size_t i = 0; i < kWheels; ++i) right[i] += other.right[i];
  seconds += other.seconds;
  turned_rad += other.turned_rad;
  return *this;
}

Eigen::Vector4cd LineMoments::right_sides(const Eigen::MatrixXd& wheel_forces) const {
  Eigen::Vector4cd b;
  for (int i = 0; i < kWheels; ++i) {
    const Eigen::MatrixXcd& of = right[static_cast<std::size_t>(i)];
    b(i) = {wheel_forces.cwiseProduct(of.real()).sum(), wheel_forces.cwiseProduct(of.imag()).sum()};
  }
  return b;
}

LineMoments line_moments(const HarmonicReading& section, Eigen::Index channels, const RoadSpectrum& density,
                         const Geometry& geometry, const ParameterVector& parameters) {
  if (section.lines.wheels.empty()) return {};
  const LineWeights weights =
      line_weights(section.lines, geometry, parameters, section.road_of(density), RoadShare::kShared);
  const Eigen::Index further = section.readings.cols() - channels;
  LineMoments sum;
  sum.normal = weights.normal;
  sum.seconds = section.seconds;
  sum.turned_rad = section.seconds * section.lines.omega;
  for (std::size_t i = 0; i < kWheels; ++i) {
    sum.right[i].setZero(kWheels, 3 * channels + further);
    for (std::size_t k = 0; k < section.lines.wheels.size(); ++k) {
      const int reference = section.lines.wheels[k];
      const double omega = section.lines.omega(reference);
      const auto phasors = section.readings.row(static_cast<Eigen::Index>(k));
      const Eigen::RowVectorXcd Z = phasors.head(channels);
      Eigen::RowVectorXcd motion(3 * channels + further);
      motion << Z, Z / (kJ * omega), -Z / (omega * omega), phasors.tail(further);
      sum.right[i] += weights.weight[i].col(reference) * motion;
    }
  }
  return sum;
}

}  // namespace roadbalance
