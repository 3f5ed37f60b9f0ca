#include "host/identify/harmonic.hpp"

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr Complex kJ(0.0, 1.0);
constexpr double kTaperFraction = 0.1;
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

}  // namespace

HarmonicInstrument::HarmonicInstrument(const VehicleConfig& vehicle, Eigen::Index samples, double rate_hz)
    : geometry_(geometry_of(vehicle.model)), taper_(c2_taper(samples, kTaperFraction, 1.0 / rate_hz)) {
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
                                                   double speed_m_s,
                                                   const ParameterVector& parameters) const {
  const LinearModel model = linear_model(geometry_, parameters);
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

  Eigen::MatrixXcd r(n, signals.cols()), down(n, signals.cols());  // [reference x sample]
  Eigen::MatrixXcd Z(n, kCoordinates);                             // [reference x coordinate]
  for (Eigen::Index k = 0; k < n; ++k) {
    const int wheel = wheels[static_cast<std::size_t>(k)];
    r.row(k) =
        signals.row(cosine_row(wheel)).cast<Complex>() + kJ * signals.row(sine_row(wheel)).cast<Complex>();
    const double power = (r.row(k).cwiseAbs2().array() * taper_.value.transpose()).sum();
    down.row(k) =
        (r.row(k).conjugate().array() * taper_.value.transpose().cast<Complex>()).matrix() * (2.0 / power);
  }
  Z = down * signals.topRows<kCoordinates>().transpose().cast<Complex>();
  // What a unit phasor of reference j gives when it is demodulated with reference k.
  const Eigen::MatrixXcd overlap = 0.5 * r * down.transpose();  // [j x k]
  Eigen::MatrixXcd K = down.conjugate() * down.transpose();     // [k x m] of conj(n_k) n_m, like the noise
  K = K.conjugate().eval() / K.diagonal().real().mean();
  K.diagonal().array() += kIndependentShare;

  const Eigen::Matrix4cd S = road_spectrum(signals, down.row(0), omega(wheels[0]), speed_m_s, parameters);
  Eigen::MatrixXcd S_used(n, n);
  for (Eigen::Index a = 0; a < n; ++a)
    for (Eigen::Index b = 0; b < n; ++b)
      S_used(a, b) = S(wheels[static_cast<std::size_t>(a)], wheels[static_cast<std::size_t>(b)]);
  const Eigen::MatrixXcd S_inverse = S_used.inverse();
  const Eigen::MatrixXcd K_inverse = K.inverse();

  for (Eigen::Index a = 0; a < n; ++a) {
    const int i = wheels[static_cast<std::size_t>(a)];
    const Eigen::RowVectorXcd weight = (omega(i) * omega(i) * overlap.row(a)).conjugate() * K_inverse;
    for (Eigen::Index b = 0; b < n; ++b) {
      const int j = wheels[static_cast<std::size_t>(b)];
      const Eigen::VectorXcd mean = omega(j) * omega(j) * overlap.row(b).transpose();
      result.normal(i, j) = S_inverse(a, b) * (weight * mean).value();
      auto& right = result.right[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
      for (Eigen::Index k = 0; k < n; ++k)
        right +=
            (S_inverse(a, b) * weight(k)) * instrument(Z.row(k), omega(wheels[static_cast<std::size_t>(k)]));
    }
  }
  return result;
}

}  // namespace roadbalance
