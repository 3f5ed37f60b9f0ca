#include "host/analysis/identify/estimate.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <complex>
#include <limits>

#include "host/analysis/identify/unbalances.hpp"

namespace roadbalance {
namespace {

constexpr int kSuspension = kEstimatedTyre;  ///< unknowns of step 1: spring[4], damper[4], stabiliser[2]
static_assert(kDamper - kSpring == kEstimatedDamper && kStabiliser - kSpring == kEstimatedStabiliser &&
              kTyre - kSpring == kEstimatedTyre);

/// Step 1's equations, one for each body row and instrument.
constexpr int kBodyEquations = kBodyCoordinates * kChassisInstruments;
using BodyColumn = Eigen::Matrix<double, kBodyEquations, 1>;

/// Each body row of (2) for each instrument with these parameters: mean force per instrument rms, over the
/// row's mass, so that all equations have one unit.
BodyColumn body_forces(const DriveMoments& moments, const LinearModel& model, const ParameterVector& known) {
  BodyColumn column;
  for (int row = 0; row < kBodyCoordinates; ++row)
    for (int i = 0; i < kChassisInstruments; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double scale = known(row) * std::sqrt(moments.chassis_power[k]);
      column(row * kChassisInstruments + i) = moments.chassis[k].force(model, row) / scale;
    }
  return column;
}

/// Step 1: A x + b = 0, x the suspension.
struct BodyEquations {
  Eigen::Matrix<double, kBodyEquations, kSuspension> A;
  BodyColumn b;
};
BodyEquations body_equations(const DriveMoments& moments, const Geometry& geometry,
                             const ParameterVector& known) {
  BodyEquations equations;
  for (int p = 0; p < kSuspension; ++p)
    equations.A.col(p) = body_forces(moments, unit_model(geometry, kSpring + p), known);
  ParameterVector masses = ParameterVector::Zero();
  masses.head<kSpring>() = known.head<kSpring>();
  equations.b = body_forces(moments, linear_model(geometry, masses), known);
  return equations;
}

/// Columns are brought to one length first; nothing if they do not determine the unknowns.
std::optional<Eigen::VectorXd> least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& right) {
  const Eigen::VectorXd size = A.colwise().norm();
  if (!(size.minCoeff() > 0.0) || !A.allFinite()) return std::nullopt;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A * size.cwiseInverse().asDiagonal());
  if (qr.rank() < A.cols()) return std::nullopt;
  return qr.solve(right).cwiseQuotient(size).eval();
}

/// Step 2.  With U = U_0 + sum_j u_j ct_j one equation per wheel for the ct asked for.
void solve_wheels(const DriveMoments& moments, const Geometry& geometry, const ParameterVector& without_tyres,
                  const UnknownSet& asked, UnknownVector& x) {
  const LinearModel known = linear_model(geometry, without_tyres);
  const Unbalances unbalances =
      solve_unbalances(moments.harmonic, geometry, without_tyres, wheels_asked_for_unbalance(asked));
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b;
  for (int i = 0; i < kWheels; ++i) {
    const auto& wheel = moments.wheel[static_cast<std::size_t>(i)];
    A(i, i) = wheel.tyre.force(unit_model(geometry, kTyre + i), kBodyCoordinates + i);
    A.row(i) -= (wheel.tyre_unbalance * unbalances.per_tyre.row(i)).real();
    b(i) = (wheel.tyre_unbalance * unbalances.without_tyres(i)).real() -
           wheel.tyre.force(known, kBodyCoordinates + i);
    if (asked[static_cast<std::size_t>(kEstimatedTyre + i)]) continue;
    A.row(i) = Eigen::RowVector4d::Unit(i);
    b(i) = x(kEstimatedTyre + i);
  }
  const Eigen::Vector4d tyre = A.partialPivLu().solve(b);
  x.segment<kWheels>(kEstimatedTyre) = tyre;
  put_unbalances(unbalances.at(tyre), unbalances.found, asked, x);
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

std::optional<SuspensionVector> solve_suspension(const DriveMoments& moments, const Geometry& geometry,
                                                 const ParameterVector& known) {
  const BodyEquations equations = body_equations(moments, geometry, known);
  const auto x = least_squares(equations.A, -equations.b);
  if (!x) return std::nullopt;
  return SuspensionVector(*x);
}

UnknownSet suspension_unknowns() {
  UnknownSet set;
  for (std::size_t i = 0; i < kSuspension; ++i) set.set(i);
  return set;
}

std::bitset<kWheels> wheels_asked_for_unbalance(const UnknownSet& asked) {
  std::bitset<kWheels> wheels;
  for (std::size_t i = 0; i < kWheels; ++i) wheels[i] = asked[kEstimatedUnbalance + 2 * i];
  return wheels;
}

void put_unbalances(const Eigen::Vector4cd& unbalance, const std::bitset<kWheels>& found,
                    const UnknownSet& asked, UnknownVector& x) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    const bool unknown = asked[kEstimatedUnbalance + 2 * w] && !found[w];
    x(kEstimatedUnbalance + 2 * i) = unknown ? kNone : unbalance(i).real();
    x(kEstimatedUnbalance + 2 * i + 1) = unknown ? kNone : unbalance(i).imag();
  }
}

std::optional<UnknownVector> solve(const DriveMoments& moments, const Geometry& geometry,
                                   const ParameterVector& known, const UnknownSet& asked) {
  if (!moments.body.normal.isZero()) return solve_body(moments.body);
  UnknownVector x = UnknownVector::Zero();
  x.head<kEstimatedUnbalance>() = known.segment<kEstimatedUnbalance>(kSpring);
  if ((asked & suspension_unknowns()).any()) {
    const auto suspension = solve_suspension(moments, geometry, known);
    if (!suspension) return std::nullopt;
    x.head<kSuspension>() = *suspension;
  }
  ParameterVector parameters = known;
  parameters.segment<kSuspension>(kSpring) = x.head<kSuspension>();
  parameters.segment<kWheels>(kTyre).setZero();
  solve_wheels(moments, geometry, parameters, asked, x);
  return x;
}

}  // namespace roadbalance
