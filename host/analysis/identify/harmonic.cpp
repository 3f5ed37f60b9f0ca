#include "host/analysis/identify/harmonic.hpp"

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "common/vehicle/unbalance_response.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;

/// Contribution of phasors of z'' at one frequency to M, P and Q of relation (1): z' = z''/(j om), z =
/// -z''/om^2.
InstrumentMoments<Complex> instrument(const Eigen::RowVectorXcd& Z, double omega) {
  return {Z, Z * (kJ / omega), -Z / (omega * omega)};
}

InstrumentMoments<Complex> operator*(Complex factor, const InstrumentMoments<Complex>& m) {
  return {factor * m.w2, factor * m.w1, factor * m.w0};
}

/// Response of the force rows of `wheels` to a unit unbalance of wheel i, demodulated with each reference:
/// Om_i^2 where row and reference are its own; small terms elsewhere because a row at one reference's rate
/// sees the neighbouring line.
Eigen::MatrixXcd expected_forces(const LinearModel& model, const std::vector<int>& wheels,
                                 const Eigen::Vector4d& omega, int i, const Eigen::RowVectorXcd& overlap) {
  const Eigen::RowVectorXcd Z = unbalance_response(model, i, omega(i)).transpose();
  const auto n = static_cast<Eigen::Index>(wheels.size());
  Eigen::MatrixXcd forces(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto m = instrument(Z, omega(wheels[static_cast<std::size_t>(k)]));
    for (Eigen::Index j = 0; j < n; ++j)
      forces(j, k) = overlap(k) * m.force(model, kBodyCoordinates + wheels[static_cast<std::size_t>(j)]);
  }
  return forces;
}

}  // namespace

Eigen::Matrix4cd RoadSpectrum::forces(const LinearModel& model) const {
  Eigen::Matrix<double, kWheels, kRows> R = Eigen::Matrix<double, kWheels, kRows>::Zero();
  for (int j = 0; j < kWheels; ++j) {
    const int row = kBodyCoordinates + j;
    R.row(j).segment<kRows / 2>(j < 2 ? 0 : kRows / 2) << model.M.row(row), -model.P.row(row),
        model.Q.row(row);
  }
  return R.cast<Complex>() * sum * R.cast<Complex>().transpose();
}

RoadSpectrum HarmonicReading::density() const {
  return {road.sum * effective_s, road.bins};
}

RoadSpectrum HarmonicReading::road_of(const RoadSpectrum& density) const {
  return {density.sum / effective_s, density.bins};
}

HarmonicReading HarmonicInstrument::read(const Eigen::Ref<const SignalMatrix>& signals,
                                         const Eigen::Vector4d& omega, double speed_m_s) const {
  return read(signals, omega, speed_m_s, Eigen::MatrixXd(0, signals.cols()),
              Eigen::ArrayXd::Ones(signals.cols()));
}

HarmonicReading HarmonicInstrument::read(const Eigen::Ref<const SignalMatrix>& signals,
                                         const Eigen::Vector4d& omega, double speed_m_s,
                                         const Eigen::Ref<const Eigen::MatrixXd>& readings,
                                         const Eigen::Ref<const Eigen::ArrayXd>& quiet) const {
  const Demodulated line = demodulator_(signals, omega, quiet);
  HarmonicReading reading{.lines = {line, omega, speed_m_s}, .road = {}};
  if (line.wheels.empty()) return reading;
  reading.readings = line.down * readings.transpose().cast<Complex>();
  reading.effective_s = line.effective_s;
  reading.seconds = quiet.sum() / rate_hz_;
  const Eigen::MatrixXcd Z = demodulator_.beside(signals, line);  // [side bin x coordinate]
  const Eigen::VectorXd& side_hz = demodulator_.side_hz();
  Eigen::Matrix<Complex, RoadSpectrum::kRows, Eigen::Dynamic> w(RoadSpectrum::kRows, side_hz.size());
  for (Eigen::Index b = 0; b < side_hz.size(); ++b) {
    const double x = 2.0 * std::numbers::pi * side_hz(b);
    const auto m = instrument(Z.row(b), omega(line.wheels.front()) + x);
    Eigen::Matrix<Complex, 1, RoadSpectrum::kRows / 2> v;
    v << m.w2, m.w1, m.w0;
    w.col(b) << v.transpose(), v.transpose() * std::polar(1.0, x * wheelbase_m_ / speed_m_s);
  }
  reading.road.sum = speed_m_s * w * w.adjoint();
  reading.road.bins = static_cast<double>(side_hz.size());
  return reading;
}

LineWeights line_weights(const SectionLines& line, const Geometry& geometry,
                         const ParameterVector& parameters, const RoadSpectrum& road, RoadShare share) {
  LineWeights result;
  for (Eigen::Matrix4cd& weight : result.weight) weight.setZero();
  const std::vector<int>& wheels = line.wheels;
  if (wheels.empty()) return result;
  const auto n = static_cast<Eigen::Index>(wheels.size());
  const auto wheel = [&](Eigen::Index k) { return wheels[static_cast<std::size_t>(k)]; };

  const LinearModel model = linear_model(geometry, parameters);
  // The inverse of a mean over B bins is too large by B / (B - n) in the mean (complex Wishart): short
  // sections, which have fewer, would count for more than they hold.
  if (road.bins <= static_cast<double>(n)) return result;
  const double scale =
      1.0 / (line.speed_m_s * (road.bins - (share == RoadShare::kShared ? static_cast<double>(n) : 1.0)));
  const Eigen::Matrix4cd forces = road.forces(model);
  const Eigen::MatrixXcd S = Eigen::MatrixXcd::NullaryExpr(n, n, [&](Eigen::Index a, Eigen::Index b) {
    return a == b || share == RoadShare::kShared ? scale * forces(wheel(a), wheel(b)) : Complex(0.0);
  });
  if (!(S.determinant().real() > 0.0)) return result;  // nothing shakes the car: no weights, no equations
  const Eigen::MatrixXcd S_inverse = S.inverse();

  std::vector<Eigen::MatrixXcd> mean(static_cast<std::size_t>(n));  // of y [row j x reference k] per unit U_i
  for (Eigen::Index i = 0; i < n; ++i)
    mean[static_cast<std::size_t>(i)] =
        expected_forces(model, wheels, line.omega, wheel(i), line.overlap.row(i));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::MatrixXcd weight =
        S_inverse.transpose() * mean[static_cast<std::size_t>(i)].conjugate() * line.K_inverse;
    for (Eigen::Index j = 0; j < n; ++j) {
      result.normal(wheel(i), wheel(j)) = weight.cwiseProduct(mean[static_cast<std::size_t>(j)]).sum();
      for (Eigen::Index k = 0; k < n; ++k)
        result.weight[static_cast<std::size_t>(wheel(i))](wheel(j), wheel(k)) = weight(j, k);
    }
  }
  return result;
}

HarmonicMoments harmonic_moments(const SectionLines& line, const Geometry& geometry,
                                 const ParameterVector& parameters, const RoadSpectrum& road,
                                 RoadShare share) {
  const LineWeights weights = line_weights(line, geometry, parameters, road, share);
  HarmonicMoments result;
  result.normal = weights.normal;
  for (const int i : line.wheels)
    for (const int j : line.wheels) {
      auto& right = result.right[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
      for (std::size_t k = 0; k < line.wheels.size(); ++k) {
        const int reference = line.wheels[k];
        right += weights.weight[static_cast<std::size_t>(i)](j, reference) *
                 instrument(line.Z.row(static_cast<Eigen::Index>(k)), line.omega(reference));
      }
    }
  return result;
}

}  // namespace roadbalance
