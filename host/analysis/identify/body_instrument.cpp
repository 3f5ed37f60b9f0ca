#include "host/analysis/identify/body_instrument.hpp"

#include <Eigen/LU>
#include <complex>
#include <vector>

#include "common/vehicle/unbalance_response.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using BodyVector = Eigen::Matrix<Complex, kBodyCoordinates, 1>;

/// Phasors of the body's accelerations per unit of a wheel's unbalance.
BodyVector response(const LinearModel& model, int wheel, double omega) {
  return unbalance_response(model, wheel, omega).head<kBodyCoordinates>();
}

}  // namespace

BodyMoments BodyInstrument::moments(const Eigen::Ref<const SignalMatrix>& signals,
                                    const Eigen::Vector4d& omega) const {
  BodyMoments result;
  const Demodulated line = demodulator_(signals, omega);
  if (line.wheels.empty()) return result;
  const Eigen::MatrixXcd beside = demodulator_.beside(signals, line).leftCols<kBodyCoordinates>();
  const Eigen::Matrix3cd S = beside.transpose() * beside.conjugate() / static_cast<double>(beside.rows());
  if (!(S.determinant().real() > 0.0)) return result;  // nothing shakes the car: no weights, no equations
  const Eigen::Matrix3cd S_inverse = S.inverse();
  const Eigen::MatrixXcd y = line.Z.leftCols<kBodyCoordinates>().transpose();  // [coordinate x reference]

  std::vector<Eigen::MatrixXcd> mean;  // of y per unit U_i
  for (Eigen::Index i = 0; i < line.overlap.rows(); ++i) {
    const int wheel = line.wheels[static_cast<std::size_t>(i)];
    mean.emplace_back(response(model_, wheel, omega(wheel)) * line.overlap.row(i));
  }
  for (std::size_t i = 0; i < mean.size(); ++i) {
    const Eigen::MatrixXcd weight = S_inverse.transpose() * mean[i].conjugate() * line.K_inverse;
    for (std::size_t j = 0; j < mean.size(); ++j)
      result.normal(line.wheels[i], line.wheels[j]) = weight.cwiseProduct(mean[j]).sum();
    result.right(line.wheels[i]) = weight.cwiseProduct(y).sum();
  }
  return result;
}

std::array<ResponseVariance, kWheels> response_variance(const VehicleConfig& vehicle, double speed_m_s) {
  const Geometry geometry = geometry_of(vehicle.model);
  const ParameterVector nominal = nominal_parameters(vehicle);
  std::array<ResponseVariance, kWheels> variance;
  for (int wheel = 0; wheel < kWheels; ++wheel) {
    const auto w = static_cast<std::size_t>(wheel);
    const double omega = speed_m_s / vehicle.wheel[w].rolling_radius_m;
    const BodyVector expected = response(linear_model(geometry, nominal), wheel, omega);
    for (int p = kSpring; p < kParameters; ++p) {
      ParameterVector changed = nominal;
      changed(p) *= 1.0 + kParameterSigma;
      const BodyVector change = response(linear_model(geometry, changed), wheel, omega) - expected;
      const Complex share = expected.dot(change) / expected.squaredNorm();
      variance[w].along += share.real() * share.real();
      variance[w].across += share.imag() * share.imag();
    }
  }
  return variance;
}

}  // namespace roadbalance
