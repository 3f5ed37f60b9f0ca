#include "host/analysis/identify/demodulation.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
/// Side bins lie this far from the line: outside every wheel's own line, near enough for one road spectrum.
constexpr double kSideFromHz = 0.3;
constexpr double kSideToHz = 2.0;
/// Wheels in step share one line: phasors that only smaller parts of the overlap separate are left
/// together.
constexpr double kApart = 1e-2;
/// Wheels in step make K singular; this share of independent noise keeps the weights finite.
constexpr double kIndependentShare = 1e-2;

/// Phasors whose sum over the references is in Z, [reference x coordinate]: Z_k = sum_j c_jk a_j.
Eigen::MatrixXcd lines(const Demodulated& line) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXcd> overlap;
  overlap.setThreshold(kApart);
  overlap.compute(line.overlap.transpose());
  return overlap.solve(line.Z);
}

}  // namespace

Demodulator::Demodulator(Taper taper, double rate_hz) : taper_(std::move(taper)), rate_hz_(rate_hz) {
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
  side_wave_.resize(2 * side, samples);
  for (Eigen::Index k = 0; k < side; ++k)
    for (Eigen::Index t = 0; t < samples; ++t) {
      const double angle = 2.0 * std::numbers::pi * side_hz_(2 * k) * static_cast<double>(t) / rate_hz;
      side_wave_(2 * k, t) = std::cos(angle);
      side_wave_(2 * k + 1, t) = std::sin(angle);
    }
}

Demodulated Demodulator::operator()(const Eigen::Ref<const SignalMatrix>& signals,
                                    const Eigen::Vector4d& omega,
                                    const Eigen::Ref<const Eigen::ArrayXd>& quiet) const {
  Demodulated result;
  for (int i = 0; i < kWheels; ++i)
    if (omega(i) > 0.0) result.wheels.push_back(i);
  if (result.wheels.empty()) return result;
  const auto n = static_cast<Eigen::Index>(result.wheels.size());
  const Eigen::ArrayXd window = taper_.value * quiet;
  result.effective_s = window.sum() * window.sum() / (window.square().sum() * rate_hz_);
  Eigen::MatrixXcd r(n, signals.cols()), down(n, signals.cols());  // [reference x sample]
  for (Eigen::Index k = 0; k < n; ++k) {
    const int wheel = result.wheels[static_cast<std::size_t>(k)];
    r.row(k) =
        signals.row(cosine_row(wheel)).cast<Complex>() + kJ * signals.row(sine_row(wheel)).cast<Complex>();
    const double power = (r.row(k).cwiseAbs2().array() * window.transpose()).sum();
    down.row(k) =
        (r.row(k).conjugate().array() * window.transpose().cast<Complex>()).matrix() * (2.0 / power);
  }
  result.Z = down * signals.topRows<kCoordinates>().transpose().cast<Complex>();
  result.overlap = 0.5 * r * down.transpose();
  Eigen::MatrixXcd K = down * down.adjoint();
  K /= K.diagonal().real().mean();
  K.diagonal().array() += kIndependentShare;
  result.K_inverse = K.inverse();
  result.down = std::move(down);
  return result;
}

Eigen::MatrixXcd Demodulator::beside(const Eigen::Ref<const SignalMatrix>& signals,
                                     const Demodulated& line) const {
  // The taper is short, its side lobes reach far: the lines themselves are taken out first.
  const Eigen::MatrixXcd phasors = lines(line);  // [reference x coordinate]
  Eigen::MatrixXd rest = signals.topRows<kCoordinates>();
  for (std::size_t k = 0; k < line.wheels.size(); ++k) {
    const auto phasor = phasors.row(static_cast<Eigen::Index>(k)).transpose();
    rest -= phasor.real() * signals.row(cosine_row(line.wheels[k])) -
            phasor.imag() * signals.row(sine_row(line.wheels[k]));
  }
  // With z down = a + j b, the bins at either side by x are sum (a + j b) (cos -+ j sin) x t.
  Eigen::MatrixXd mixed(rest.cols(), 2 * kCoordinates);  // [sample x a, b of each coordinate]
  mixed << line.down.row(0).real().asDiagonal() * rest.transpose(),
      line.down.row(0).imag().asDiagonal() * rest.transpose();
  const Eigen::MatrixXd sums = side_wave_ * mixed;
  Eigen::MatrixXcd Z(sums.rows(), kCoordinates);
  for (Eigen::Index k = 0; k < sums.rows(); k += 2) {
    const auto a_cos = sums.row(k).head<kCoordinates>(), b_cos = sums.row(k).tail<kCoordinates>();
    const auto a_sin = sums.row(k + 1).head<kCoordinates>(), b_sin = sums.row(k + 1).tail<kCoordinates>();
    Z.row(k) = (a_cos + b_sin).cast<Complex>() + kJ * (b_cos - a_sin).cast<Complex>();
    Z.row(k + 1) = (a_cos - b_sin).cast<Complex>() + kJ * (b_cos + a_sin).cast<Complex>();
  }
  return Z;
}

}  // namespace roadbalance
