#include "tools/study/exact_covariance.hpp"

#include <Eigen/LU>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "common/linear/lyapunov.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
constexpr Eigen::Index kRoad = 2 * kCoordinates;  ///< first road state
constexpr Eigen::Index kFilter = kRoad + 2 * kWheels;

}  // namespace

ExactDrive::ExactDrive(const Geometry& geometry, const ParameterVector& parameters,
                       const std::array<std::complex<double>, kWheels>& unbalance_kg_m, double speed_m_s,
                       double rolling_radius_m, double road_gd_m3, const ContinuousFilter& filter,
                       double corner_hz)
    : corner_rad_s_(2.0 * pi * corner_hz), order_(filter.G.size()) {
  const LinearModel model = linear_model(geometry, parameters);
  const Matrix7 inverse_mass = model.M.inverse();
  const Eigen::Index n = kFilter + kCoordinates * order_;
  acceleration_rows_ = Eigen::MatrixXd::Zero(kCoordinates, n);
  acceleration_rows_.leftCols(kCoordinates) = -inverse_mass * model.Q;
  acceleration_rows_.middleCols(kCoordinates, kCoordinates) = -inverse_mass * model.P;
  A_ = Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(n, kWheels);
  const double w1 = 2.0 * pi * kLeastWave_1_m * speed_m_s, w2 = 2.0 * pi * kPatchWave_1_m * speed_m_s;
  for (int i = 0; i < kWheels; ++i) {  // u = 1/(s + w1) w2/(s + w2) w
    const Eigen::Index shaping = kRoad + 2 * i;
    acceleration_rows_.col(shaping + 1) = inverse_mass * model.S.col(i);
    A_(shaping, shaping) = -w2;
    A_(shaping + 1, shaping) = 1.0;
    A_(shaping + 1, shaping + 1) = -w1;
    B(shaping, i) = w2 * std::sqrt(2.0 * pi * pi * 0.01 * road_gd_m3 * speed_m_s);
  }
  A_.block(0, kCoordinates, kCoordinates, kCoordinates).setIdentity();
  A_.middleRows(kCoordinates, kCoordinates) = acceleration_rows_;
  for (int c = 0; c < kCoordinates; ++c) {
    const Eigen::Index first = kFilter + c * order_;
    A_.block(first, first, order_, order_) = filter.F;
    A_.middleRows(first, order_) += filter.G * acceleration_rows_.row(c);
  }
  // States in units of their own standard deviation: the exponential and Lyapunov's equation then lose no
  // digits.
  scale_ = continuous_lyapunov(A_, B * B.transpose()).diagonal().cwiseSqrt();
  A_ = (scale_.cwiseInverse().asDiagonal() * A_ * scale_.asDiagonal()).eval();
  B = (scale_.cwiseInverse().asDiagonal() * B).eval();
  X_ = continuous_lyapunov(A_, B * B.transpose());

  phasor_.resize(kCoordinates, kWheels);
  const std::complex<double> j(0.0, 1.0);
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    const double om = speed_m_s / rolling_radius_m * (1.0 + 0.003 * i);  // no two wheels in step
    omega_[w] = om;
    force_[w] = unbalance_kg_m[w] * om * om;
    const Eigen::MatrixXcd dynamic = model.Q + j * om * model.P - om * om * model.M;
    phasor_.col(i) =
        -om * om * dynamic.partialPivLu().solve(model.W.col(i).cast<std::complex<double>>() * force_[w]);
    const Eigen::MatrixXcd resolvent = j * om * Eigen::MatrixXcd::Identity(order_, order_) - filter.F;
    filter_response_.push_back(resolvent.partialPivLu().solve(filter.G.cast<std::complex<double>>()));
  }
}

ExactDrive::Row ExactDrive::filter_state(int signal, int k) const {
  Row row{Eigen::RowVectorXd::Zero(A_.rows()), Eigen::RowVectorXcd::Zero(kWheels)};
  if (signal < kCoordinates) row.state(kFilter + signal * order_ + k) = 1.0;
  for (int i = 0; i < kWheels; ++i) {
    // cos alpha = Re{e^{j alpha}}, sin alpha = Re{-j e^{j alpha}}.
    const std::complex<double> own = signal == cosine_row(i) ? 1.0 : std::complex<double>(0.0, -1.0);
    const bool reference = signal == cosine_row(i) || signal == sine_row(i);
    const std::complex<double> input = signal < kCoordinates ? phasor_(signal, i) : reference ? own : 0.0;
    row.phasor(i) = filter_response_[static_cast<std::size_t>(i)](k) * input;
  }
  return row;
}

const Eigen::MatrixXd& ExactDrive::at_lag(double lag_s) const {
  const auto [found, missing] = at_lag_.try_emplace(lag_s);
  if (missing && lag_s >= 0.0) found->second = X_ * (A_ * lag_s).exp().transpose();
  if (missing && lag_s < 0.0) found->second = (A_ * -lag_s).exp() * X_;
  return found->second;
}

double ExactDrive::covariance(const Row& past, const Eigen::RowVectorXd& future_state,
                              const Eigen::RowVectorXcd& future_phasor, double lag_s) const {
  double sum =
      past.state * scale_.asDiagonal() * at_lag(lag_s) * scale_.asDiagonal() * future_state.transpose();
  for (int i = 0; i < kWheels; ++i)
    sum += 0.5 * (std::conj(past.phasor(i)) * future_phasor(i) * std::polar(1.0, omega(i) * lag_s)).real();
  return sum;
}

InstrumentMoments<double> ExactDrive::moments(int signal, int j, double lag_s) const {
  InstrumentMoments<double> m;
  for (int c = 0; c < kCoordinates; ++c) {
    const auto with = [&](int k) {
      return covariance(filter_state(signal, j + k), acceleration_rows_.row(c), phasor_.row(c), lag_s);
    };
    m.w2(c) = with(2);
    m.w1(c) = with(1) / corner_rad_s_;
    m.w0(c) = with(0) / (corner_rad_s_ * corner_rad_s_);
  }
  return m;
}

Eigen::RowVector4d ExactDrive::with_road(int signal, int j, double lag_s) const {
  Eigen::RowVector4d row;
  for (int i = 0; i < kWheels; ++i) {
    Eigen::RowVectorXd u = Eigen::RowVectorXd::Zero(A_.rows());
    u(kRoad + 2 * i + 1) = 1.0;
    row(i) = covariance(filter_state(signal, j + 2), u, Eigen::RowVectorXcd::Zero(kWheels), lag_s);
  }
  return row;
}

Eigen::RowVector4d ExactDrive::with_unbalance_force(int signal, int j, double lag_s) const {
  Eigen::RowVector4d row;
  for (int i = 0; i < kWheels; ++i) {
    Eigen::RowVectorXcd force = Eigen::RowVectorXcd::Zero(kWheels);
    force(i) = force_[static_cast<std::size_t>(i)];
    row(i) = covariance(filter_state(signal, j + 2), Eigen::RowVectorXd::Zero(A_.rows()), force, lag_s);
  }
  return row;
}

std::complex<double> ExactDrive::with_reference(int signal, int j, double lag_s, int wheel) const {
  const double om = omega(wheel);
  return om * om * 0.5 * std::conj(filter_state(signal, j + 2).phasor(wheel)) * std::polar(1.0, om * lag_s);
}

double ExactDrive::power(int signal, int j) const {
  const Row row = filter_state(signal, j + 2);
  return covariance(row, row.state, row.phasor, 0.0);
}

}  // namespace roadbalance
