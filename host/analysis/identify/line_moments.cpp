#include "host/analysis/identify/line_moments.hpp"

#include <algorithm>

#include "common/dsp/taper.hpp"

namespace roadbalance {
namespace {

constexpr double kRise_s = 1.0;

}  // namespace

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

RoadSpectrum LineReading::density() const {
  RoadSpectrum density = reading.road;
  density.sum *= reading.effective_s;
  return density;
}

const HarmonicInstrument& HarmonicReader::instrument(Eigen::Index samples) {
  const auto found = instruments_.find(samples);
  if (found != instruments_.end()) return found->second;
  const double share = std::min(0.5, kRise_s * rate_hz_ / static_cast<double>(samples));
  return instruments_
      .emplace(samples, HarmonicInstrument(geometry_, c2_taper(samples, share, 1.0 / rate_hz_), rate_hz_))
      .first->second;
}

LineReading HarmonicReader::read(const Eigen::Ref<const SignalMatrix>& signals,
                                 const Eigen::Ref<const Eigen::MatrixXd>& readings,
                                 const Eigen::Ref<const Eigen::ArrayXd>& quiet, const Eigen::Vector4d& omega,
                                 double speed_m_s) {
  return {.reading = instrument(signals.cols()).read(signals, omega, speed_m_s, readings, quiet),
          .seconds = quiet.sum() / rate_hz_};
}

LineMoments line_moments(const LineReading& section, Eigen::Index channels, const RoadSpectrum& density,
                         const Geometry& geometry, const ParameterVector& parameters) {
  const HarmonicReading& reading = section.reading;
  RoadSpectrum road = density;
  road.sum /= reading.effective_s;
  const LineWeights weights = line_weights(reading.lines, geometry, parameters, road, RoadShare::kShared);
  const Eigen::Index further = reading.readings.cols() - channels;
  LineMoments sum;
  sum.normal = weights.normal;
  sum.seconds = section.seconds;
  sum.turned_rad = section.seconds * reading.lines.omega;
  for (std::size_t i = 0; i < kWheels; ++i) {
    sum.right[i].setZero(kWheels, 3 * channels + further);
    for (std::size_t k = 0; k < reading.lines.wheels.size(); ++k) {
      const int reference = reading.lines.wheels[k];
      const double omega = reading.lines.omega(reference);
      const auto phasors = reading.readings.row(static_cast<Eigen::Index>(k));
      const Eigen::RowVectorXcd Z = phasors.head(channels);
      Eigen::RowVectorXcd motion(3 * channels + further);
      motion << Z, Z / (kJ * omega), -Z / (omega * omega), phasors.tail(further);
      sum.right[i] += weights.weight[i].col(reference) * motion;
    }
  }
  return sum;
}

}  // namespace roadbalance
