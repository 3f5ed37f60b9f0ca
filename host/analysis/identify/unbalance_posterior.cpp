#include "host/analysis/identify/unbalance_posterior.hpp"

#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "host/analysis/identify/unbalances.hpp"

namespace roadbalance {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kAxes = 2 * kWheels;  ///< Re, Im of each wheel
using Axes = Eigen::Matrix<double, kAxes, kAxes>;
using AxesVector = Eigen::Matrix<double, kAxes, 1>;

AxesVector axes(const Eigen::Vector4cd& phasors) {
  AxesVector parts;
  for (int i = 0; i < kWheels; ++i) parts.segment<2>(2 * i) << phasors(i).real(), phasors(i).imag();
  return parts;
}

/// As a real matrix on [Re, Im].
Axes axes(const Eigen::Matrix4cd& matrix) {
  Axes all;
  for (int i = 0; i < kWheels; ++i)
    for (int j = 0; j < kWheels; ++j) {
      const std::complex<double> c = matrix(i, j);
      all.block<2, 2>(2 * i, 2 * j) << c.real(), -c.imag(), c.imag(), c.real();
    }
  return all;
}

std::complex<double> phasor(const VectorXd& parts, Index at) {
  return {parts(at), parts(at + 1)};
}

}  // namespace

UnbalancePosterior unbalance_posterior(const CarPosterior& car, const PosteriorMode& mode,
                                       std::span<const LineMoments> lines) {
  constexpr double kStep = 1e-3;  // of a standard deviation, for differences: forces are almost linear
  const Index known = car.known();
  const MatrixXd rigid_forces = car.wheel_forces(mode.v);
  const Index brackets = car.first_bracket();
  std::vector<MatrixXd> rigid_forces_by;
  for (Index a = 0; a < (brackets < 0 ? known : brackets); ++a) {
    VectorXd moved = mode.v;
    moved(a) += kStep;
    rigid_forces_by.push_back((car.wheel_forces(moved) - rigid_forces) / kStep);
  }

  // Unknowns: U, then R by axes, then v - v_0.
  const Index size = 2 * kAxes + known;
  MatrixXd information = MatrixXd::Zero(size, size);
  VectorXd right = VectorXd::Zero(size);
  information.diagonal().segment<kAxes>(kAxes).setConstant(1.0 / (kRadialForceSigma_n * kRadialForceSigma_n));
  information.bottomRightCorner(known, known) = mode.covariance.topLeftCorner(known, known).inverse();
  AxesVector squares = AxesVector::Zero(), fourths = AxesVector::Zero();
  for (const LineMoments& moments : lines) {
    if (moments.normal.isZero()) continue;
    const double line = moments.omega().maxCoeff();
    const auto mounted = unbracketed(car.brackets_s2(mode.v), rigid_forces.cols(), line).matrix().eval();
    const MatrixXd forces = rigid_forces * mounted.asDiagonal();
    std::vector<MatrixXd> forces_by;
    for (const MatrixXd& by : rigid_forces_by) forces_by.push_back(by * mounted.asDiagonal());
    for (Index c = 0; brackets >= 0 && c < car.channels(); ++c) {
      const VectorXd one = car.prior().bracket_sigma_s2 * VectorXd::Unit(car.channels(), c);
      forces_by.push_back(rigid_forces *
                          (unbracketed(one, rigid_forces.cols(), line) - 1.0).matrix().asDiagonal());
    }
    const AxesVector omega = moments.omega()(Eigen::ArrayXi::LinSpaced(kAxes, 0, kAxes - 1) / 2);
    const AxesVector square = omega.cwiseAbs2();
    squares += moments.seconds * square;
    fourths += moments.seconds * square.cwiseAbs2();
    // Each component of circular noise has half of its variance.
    const Axes normal = 2.0 * axes(moments.normal);
    Axes scatter = axes(inverse_where_known(moments.normal)) / 2.0;
    Eigen::Matrix<double, kAxes, kWheels> drift = Eigen::Matrix<double, kAxes, kWheels>::Zero();
    for (int i = 0; i < kWheels; ++i)
      if (const Index a = car.place(kTyre + i); a >= 0)
        drift.col(i) = kTyreDriftSigma / car.prior().sigma(kTyre + i) * 2.0 *
                       axes(moments.right_sides(forces_by[static_cast<std::size_t>(a)]));
    // (N + D D')^-1
    const Eigen::Matrix<double, kAxes, kWheels> spread = scatter * drift;
    scatter -=
        spread * (Eigen::Matrix4d::Identity() + drift.transpose() * spread).inverse() * spread.transpose();
    MatrixXd by(kAxes, size);  // what is to explain N y
    const AxesVector inverse_square = (square.array() > 0.0).select(square.cwiseInverse(), 0.0);
    by.leftCols<kAxes>() = normal;
    by.middleCols<kAxes>(kAxes) = normal * inverse_square.asDiagonal();
    for (Index a = 0; a < known; ++a)
      by.col(2 * kAxes + a) = -2.0 * axes(moments.right_sides(forces_by[static_cast<std::size_t>(a)]));
    information += by.transpose() * scatter * by;
    right += by.transpose() * scatter * (2.0 * axes(moments.right_sides(forces)));
  }
  // Kilogram metres are small beside newtons: all in standard deviations.
  const VectorXd scale =
      (information.diagonal().array() > 0.0).select(information.diagonal().cwiseSqrt().cwiseInverse(), 1.0);
  const MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const auto covariance_of_first = [&](Index count) -> MatrixXd {
    const auto part = scale.head(count).asDiagonal();
    return part * scaled.topLeftCorner(count, count).ldlt().solve(MatrixXd::Identity(count, count)) * part;
  };
  const MatrixXd covariance = covariance_of_first(size), heard = covariance_of_first(2 * kAxes);
  const VectorXd found = covariance * right;

  UnbalancePosterior result;
  result.v = mode.v.head(known) + found.tail(known);
  result.covariance = covariance.bottomRightCorner(known, known);
  for (int i = 0; i < kWheels; ++i) {
    WheelFirstOrder& wheel = result.wheel[static_cast<std::size_t>(i)];
    const Index u = 2 * i, r = kAxes + 2 * i;
    wheel.unbalance_kg_m = phasor(found, u);
    wheel.unbalance_covariance = covariance.block<2, 2>(u, u);
    wheel.force_n = phasor(found, r);
    wheel.force_covariance = covariance.block<2, 2>(r, r);
    if (!(fourths(u) > 0.0)) {
      constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
      wheel.unbalance_kg_m = wheel.force_n = wheel.correction_kg_m = {kNone, kNone};
      wheel.unbalance_covariance.setConstant(kNone);
      wheel.force_covariance.setConstant(kNone);
      wheel.correction_covariance.setConstant(kNone);
      wheel.heard_covariance.setConstant(kNone);
      continue;
    }
    const double share = squares(u) / fourths(u);
    wheel.correction_kg_m = wheel.unbalance_kg_m + share * wheel.force_n;
    Eigen::Matrix<double, 2, 2 * kAxes> sum = Eigen::Matrix<double, 2, 2 * kAxes>::Zero();  // U + share R
    sum.middleCols<2>(u).setIdentity();
    sum.middleCols<2>(r) = share * Eigen::Matrix2d::Identity();
    wheel.correction_covariance = sum * covariance.topLeftCorner<2 * kAxes, 2 * kAxes>() * sum.transpose();
    wheel.heard_covariance = sum * heard * sum.transpose();
  }
  return result;
}

}  // namespace roadbalance
