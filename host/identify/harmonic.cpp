#include "host/identify/harmonic.hpp"

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr Complex kJ(0.0, 1.0);
/// Side bins lie this far from the line: outside every wheel's own line, near enough for one road spectrum.
constexpr double kSideFromHz = 0.3;
constexpr double kSideToHz = 2.0;
/// Wheels in step make K singular; this share of independent noise keeps the weights finite.
constexpr double kIndependentShare = 1e-2;

/// What phasors of z'' at one frequency contribute to M, P and Q of relation (1): z' = z''/(j om), z =
/// -z''/om^2.
InstrumentMoments<Complex> instrument(const Eigen::RowVectorXcd& Z, double omega) {
  return {Z, Z * (kJ / omega), -Z / (omega * omega)};
}

InstrumentMoments<Complex> operator*(Complex factor, const InstrumentMoments<Complex>& m) {
  return {factor * m.w2, factor * m.w1, factor * m.w0};
}

/// What a unit unbalance of wheel i leaves in the force rows of `wheels`, demodulated with each reference:
/// Om_i^2 where row and reference are its own; small terms elsewhere because a row at one reference's rate
/// sees the neighbouring line.
Eigen::MatrixXcd expected_forces(const LinearModel& model, const std::vector<int>& wheels,
                                 const Eigen::Vector4d& omega, int i, const Eigen::RowVectorXcd& overlap) {
  const double om = omega(i);
  const Eigen::Matrix<Complex, kCoordinates, kCoordinates> dynamic =
      model.Q.cast<Complex>() + kJ * om * model.P.cast<Complex>() - (om * om * model.M).cast<Complex>();
  const Eigen::RowVectorXcd Z =
      (-om * om * om * om * dynamic.partialPivLu().solve(model.W.col(i).cast<Complex>())).transpose();
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

HarmonicInstrument::HarmonicInstrument(const VehicleConfig& vehicle, Taper taper, double rate_hz)
    : geometry_(geometry_of(vehicle.model)), taper_(std::move(taper)) {
  const Eigen::Index samples = taper_.value.size();
  const double step_hz = rate_hz / static_cast<double>(samples);
  const auto first = static_cast<Eigen::Index>(std::ceil(kSideFromHz / step_hz - 1e-9));
  const auto last = static_cast<Eigen::Index>(std::floor(kSideToHz / step_hz + 1e-9));
  const Eigen::Index side = last - first + 1;
  side_hz_.resize(2 * side);
  for (Eigen::Index k = 0; k < side; ++k) {
    side_hz_(2 * k) = static_cast<double>(first + k) * step_hz;
    side_hz_(2 * k + 1) = -side_hz_(2 * k);
  }
  side_shift_.resize(side_hz_.size(), samples);
  for (Eigen::Index b = 0; b < side_hz_.size(); ++b)
    for (Eigen::Index t = 0; t < samples; ++t)
      side_shift_(b, t) =
          std::polar(1.0, -2.0 * std::numbers::pi * side_hz_(b) * static_cast<double>(t) / rate_hz);
}

Eigen::Matrix4cd HarmonicInstrument::road_spectrum(const Eigen::Ref<const SignalMatrix>& signals,
                                                   const Eigen::RowVectorXcd& down, double omega,
                                                   double speed_m_s, const LinearModel& model) const {
  const Eigen::MatrixXcd mixed =
      (down.asDiagonal() * signals.topRows<kCoordinates>().transpose().cast<Complex>()).eval();
  const Eigen::MatrixXcd Z = side_shift_ * mixed;  // [side bin x coordinate]
  Eigen::Matrix4cd spectrum = Eigen::Matrix4cd::Zero();
  for (Eigen::Index b = 0; b < side_hz_.size(); ++b) {
    const double x = 2.0 * std::numbers::pi * side_hz_(b);
    const auto m = instrument(Z.row(b), omega + x);
    Eigen::Vector4cd force;
    for (int j = 0; j < kWheels; ++j) {
      const double later_s = (geometry_.x_m[0] - geometry_.x_m[static_cast<std::size_t>(j)]) / speed_m_s;
      force(j) = m.force(model, kBodyCoordinates + j) * std::polar(1.0, x * later_s);
    }
    spectrum += force * force.adjoint();
  }
  return spectrum / static_cast<double>(side_hz_.size());
}

HarmonicMoments HarmonicInstrument::moments(const Eigen::Ref<const SignalMatrix>& signals,
                                            const Eigen::Vector4d& omega, double speed_m_s,
                                            const ParameterVector& parameters) const {
  HarmonicMoments result;
  std::vector<int> wheels;  // that have a reference
  for (int i = 0; i < kWheels; ++i)
    if (omega(i) > 0.0) wheels.push_back(i);
  if (wheels.empty()) return result;
  const auto n = static_cast<Eigen::Index>(wheels.size());
  const auto wheel = [&](Eigen::Index k) { return wheels[static_cast<std::size_t>(k)]; };

  Eigen::MatrixXcd r(n, signals.cols()), down(n, signals.cols());  // [reference x sample]
  for (Eigen::Index k = 0; k < n; ++k) {
    r.row(k) = signals.row(cosine_row(wheel(k))).cast<Complex>() +
               kJ * signals.row(sine_row(wheel(k))).cast<Complex>();
    const double power = (r.row(k).cwiseAbs2().array() * taper_.value.transpose()).sum();
    down.row(k) =
        (r.row(k).conjugate().array() * taper_.value.transpose().cast<Complex>()).matrix() * (2.0 / power);
  }
  const Eigen::MatrixXcd Z = down * signals.topRows<kCoordinates>().transpose().cast<Complex>();
  const Eigen::MatrixXcd overlap = 0.5 * r * down.transpose();  // c [j x k]
  Eigen::MatrixXcd K = down * down.adjoint();
  K /= K.diagonal().real().mean();
  K.diagonal().array() += kIndependentShare;

  const LinearModel model = linear_model(geometry_, parameters);
  const Eigen::Matrix4cd spectrum = road_spectrum(signals, down.row(0), omega(wheel(0)), speed_m_s, model);
  const Eigen::MatrixXcd S = Eigen::MatrixXcd::NullaryExpr(
      n, n, [&](Eigen::Index a, Eigen::Index b) { return spectrum(wheel(a), wheel(b)); });
  if (!(S.determinant().real() > 0.0)) return result;  // nothing shakes the car: no weights, no equations
  const Eigen::MatrixXcd S_inverse = S.inverse();
  const Eigen::MatrixXcd K_inverse = K.inverse();

  std::vector<Eigen::MatrixXcd> mean(static_cast<std::size_t>(n));  // of y [row j x reference k] per unit U_i
  for (Eigen::Index i = 0; i < n; ++i)
    mean[static_cast<std::size_t>(i)] = expected_forces(model, wheels, omega, wheel(i), overlap.row(i));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::MatrixXcd weight =
        S_inverse.transpose() * mean[static_cast<std::size_t>(i)].conjugate() * K_inverse;
    for (Eigen::Index j = 0; j < n; ++j) {
      result.normal(wheel(i), wheel(j)) = weight.cwiseProduct(mean[static_cast<std::size_t>(j)]).sum();
      auto& right = result.right[static_cast<std::size_t>(wheel(i))][static_cast<std::size_t>(wheel(j))];
      for (Eigen::Index k = 0; k < n; ++k) right += weight(j, k) * instrument(Z.row(k), omega(wheel(k)));
    }
  }
  return result;
}

}  // namespace roadbalance
