#include "host/analysis/identify/estimators/line_phasors.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace roadbalance {
namespace {

constexpr double kPart_s = 10.0;
constexpr double kTaperFraction = 0.2;

}  // namespace

LinePhasors& LinePhasors::operator+=(const LinePhasors& other) {
  seconds += other.seconds;
  turned_rad += other.turned_rad;
  Z += other.Z;
  C += other.C;
  K += other.K;
  beside += other.beside;
  bins += other.bins;
  return *this;
}

void LineCorrelator::parts(const Stretch& stretch, const Emit& emit) {
  const auto count = std::max<Eigen::Index>(1, static_cast<Eigen::Index>(stretch.seconds() / kPart_s));
  const Eigen::Index samples = stretch.signals.cols() / count;
  Eigen::Vector4d omega = stretch.omega;
  for (int i = 0; i < kWheels; ++i)
    if (!wheels_[static_cast<std::size_t>(i)]) omega(i) = 0.0;
  if (samples < 2 || !(omega.maxCoeff() > 0.0)) return;
  const Demodulator& demodulator =
      demodulators_
          .try_emplace({stretch.rate_hz, samples}, c2_taper(samples, kTaperFraction, 1.0 / stretch.rate_hz),
                       stretch.rate_hz)
          .first->second;
  for (Eigen::Index part = 0; part < count; ++part) {
    const auto signals = stretch.signals.middleCols(part * samples, samples);
    const Demodulated line = demodulator(signals, omega);
    LinePhasors sum;
    sum.seconds = static_cast<double>(samples) / stretch.rate_hz;
    sum.turned_rad = sum.seconds * omega;
    sum.Z(line.wheels, Eigen::all) = line.Z;
    sum.C(line.wheels, line.wheels) = line.overlap;
    sum.K(line.wheels, line.wheels) = Eigen::MatrixXcd(line.K_inverse.inverse());
    const Eigen::MatrixXcd side = demodulator.beside(signals, line);
    sum.beside = side.transpose() * side.conjugate();
    sum.bins = static_cast<double>(side.rows());
    emit(sum);
  }
}

}  // namespace roadbalance
