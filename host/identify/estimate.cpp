#include "host/identify/estimate.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <complex>
#include <limits>

namespace roadbalance {
namespace {

constexpr int kSuspension = kEstimatedTyre;  ///< unknowns of step 1: spring[4], damper[4], stabiliser[2]
static_assert(kDamper - kSpring == kEstimatedDamper && kStabiliser - kSpring == kEstimatedStabiliser &&
              kTyre - kSpring == kEstimatedTyre);

LinearModel unit_model(const Geometry& geometry, int parameter) {
  ParameterVector unit = ParameterVector::Zero();
  unit(parameter) = 1.0;
  return linear_model(geometry, unit);
}

/// Step 1.  Equations: each body row of (2) for each instrument; unknowns: the suspension.
std::optional<Eigen::Matrix<double, kSuspension, 1>> solve_suspension(const DriveMoments& moments,
                                                                      const Geometry& geometry,
                                                                      const ParameterVector& known) {
  constexpr int kEquations = kBodyCoordinates * kChassisInstruments;
  Eigen::Matrix<double, kEquations, kSuspension> A;
  Eigen::Matrix<double, kEquations, 1> b;
  ParameterVector masses = ParameterVector::Zero();
  masses.head<kSpring>() = known.head<kSpring>();
  const auto fill = [&](const LinearModel& model, auto column) {
    for (int row = 0; row < kBodyCoordinates; ++row)
      for (int i = 0; i < kChassisInstruments; ++i) {
        const auto k = static_cast<std::size_t>(i);
        // One unit for all equations: mean force per instrument rms, over the row's mass.
        const double scale = known(row) * std::sqrt(moments.chassis_power[k]);
        column(row * kChassisInstruments + i) = moments.chassis[k].force(model, row) / scale;
      }
  };
  for (int p = 0; p < kSuspension; ++p) fill(unit_model(geometry, kSpring + p), A.col(p));
  fill(linear_model(geometry, masses), b.col(0));
  const Eigen::Matrix<double, kSuspension, 1> size = A.colwise().norm();
  if (!(size.minCoeff() > 0.0) || !A.allFinite()) return std::nullopt;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A * size.cwiseInverse().asDiagonal());
  if (qr.rank() < kSuspension) return std::nullopt;
  return (-qr.solve(b)).cwiseQuotient(size).eval();
}

/// Right side of the normal equations of the unbalances, contribution of the force on one wheel.
Eigen::Vector4cd unbalance_right_side(const HarmonicMoments& moments, const LinearModel& model, int wheel) {
  Eigen::Vector4cd right;
  for (int i = 0; i < kWheels; ++i)
    right(i) = moments.right[static_cast<std::size_t>(i)][static_cast<std::size_t>(wheel)].force(
        model, kBodyCoordinates + wheel);
  return right;
}

/// Inverse of N over the wheels that have equations, zero elsewhere.
Eigen::Matrix4cd inverse_where_known(const Eigen::Matrix4cd& normal) {
  Eigen::Matrix4cd filled = normal;
  for (int i = 0; i < kWheels; ++i)
    if (normal(i, i) == 0.0) filled(i, i) = 1.0;
  Eigen::Matrix4cd inverse = filled.inverse();
  for (int i = 0; i < kWheels; ++i)
    if (normal(i, i) == 0.0) inverse(i, i) = 0.0;
  return inverse;
}

/// Step 2.  U = u0 + sum_j u_j ct_j from the references; with it one equation per wheel for the four ct.
void solve_wheels(const DriveMoments& moments, const Geometry& geometry, const ParameterVector& without_tyres,
                  UnknownVector& x) {
  const LinearModel known = linear_model(geometry, without_tyres);
  const Eigen::Matrix4cd inverse = inverse_where_known(moments.harmonic.normal);
  Eigen::Vector4cd u0 = Eigen::Vector4cd::Zero();
  Eigen::Matrix4cd u;  // column j: per unit of ct_j
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b;
  for (int j = 0; j < kWheels; ++j) {
    const LinearModel unit = unit_model(geometry, kTyre + j);
    u0 += inverse * unbalance_right_side(moments.harmonic, known, j);
    u.col(j) = inverse * unbalance_right_side(moments.harmonic, unit, j);
    const auto& wheel = moments.wheel[static_cast<std::size_t>(j)];
    A(j, j) = wheel.tyre.force(unit, kBodyCoordinates + j);
    b(j) = -wheel.tyre.force(known, kBodyCoordinates + j);
  }
  for (int i = 0; i < kWheels; ++i) {
    const auto share = moments.wheel[static_cast<std::size_t>(i)].tyre_unbalance;
    A.row(i) -= (share * u.row(i)).real();
    b(i) += (share * u0(i)).real();
  }
  const Eigen::Vector4d tyre = A.partialPivLu().solve(b);
  x.segment<kWheels>(kEstimatedTyre) = tyre;
  const Eigen::Vector4cd unbalance = u0 + u * tyre.cast<std::complex<double>>();
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < kWheels; ++i) {
    const bool referenced = moments.harmonic.normal(i, i) != 0.0;
    x(kEstimatedUnbalance + 2 * i) = referenced ? unbalance(i).real() : kNone;
    x(kEstimatedUnbalance + 2 * i + 1) = referenced ? unbalance(i).imag() : kNone;
  }
}

std::optional<UnknownVector> solve_body(const BodyMoments& body) {
  const Eigen::Vector4cd unbalance = inverse_where_known(body.normal) * body.right;
  if (!unbalance.allFinite()) return std::nullopt;
  UnknownVector x = UnknownVector::Constant(std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < kWheels; ++i)
    if (body.normal(i, i) != 0.0)
      x.segment<2>(kEstimatedUnbalance + 2 * i) << unbalance(i).real(), unbalance(i).imag();
  return x;
}

}  // namespace

std::optional<UnknownVector> solve(const DriveMoments& moments, const Geometry& geometry,
                                   const ParameterVector& known) {
  if (!moments.body.normal.isZero()) return solve_body(moments.body);
  const auto suspension = solve_suspension(moments, geometry, known);
  if (!suspension) return std::nullopt;
  UnknownVector x;
  x.head<kSuspension>() = *suspension;

  ParameterVector parameters = known;
  parameters.segment<kSuspension>(kSpring) = *suspension;
  parameters.segment<kWheels>(kTyre).setZero();
  solve_wheels(moments, geometry, parameters, x);
  return x;
}

}  // namespace roadbalance
