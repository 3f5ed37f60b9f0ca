#include "host/analysis/identify/estimate_covariance.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/analysis/identify/confidence.hpp"
#include "host/analysis/identify/speed_forces.hpp"

namespace roadbalance {
namespace {

/// One vector of all that a drive determines: the unknowns, the wheels' residuals, unbalance and force of
/// each wheel, the shares by which the body's inertias seem wrong.
constexpr int kResiduals = kUnknowns;
constexpr int kForces = kResiduals + kWheels * kWheelChecks;
constexpr int kForceParts = 4;  ///< of a wheel: Re U, Im U, Re R, Im R
constexpr int kInertias = kForces + kForceParts * kWheels;
constexpr int kDriveVector = kInertias + 2;
using DriveVector = Eigen::Matrix<double, kDriveVector, 1>;
using DriveMatrix = Eigen::Matrix<double, kDriveVector, kDriveVector>;
struct DriveSolution {
  DriveVector vector = DriveVector::Zero();
  BodyColumn body_residual = BodyColumn::Zero();
};
using Changes = Eigen::Matrix<double, kDriveVector, kSpring>;

/// Share of a wheel's mass that the contact patch's rest of the road at the tyre's lag amounts to.
constexpr double kPatchShare = 0.01;
/// Share of an inertia that sampling, and a car that no equation holds exactly, amount to.
constexpr double kInertiaShare = 0.005;
/// The same of all that moves the body: twice what linear cars leave, 0.09 to 0.13 % on roads of class A and
/// B.
constexpr double kBodyShare = 0.002;
constexpr double kStep = 0.01;  ///< of a parameter, for differences

std::array<FirstOrderFit, kWheels> fit_forces(const std::vector<DriveMoments>& classes,
                                              const UnknownVector& x, const Priors& priors) {
  std::array<std::vector<FirstOrderForce>, kWheels> forces;
  for (const SpeedForces& speed : drive_forces(classes, x, priors).speed)
    for (std::size_t w = 0; w < kWheels; ++w)
      if (speed.wheel[w].variance_n2 > 0.0) forces[w].push_back(speed.wheel[w]);
  std::array<FirstOrderFit, kWheels> fits{};
  for (std::size_t w = 0; w < kWheels; ++w)
    if (!forces[w].empty()) fits[w] = fit_first_order(forces[w]);
  return fits;
}

DriveMoments sum_of(const std::vector<DriveMoments>& classes) {
  DriveMoments sum;
  for (const DriveMoments& total : classes) sum += total;
  return sum;
}

std::optional<DriveSolution> solve_drive(const std::vector<DriveMoments>& classes, const Priors& priors) {
  const DriveMoments drive = sum_of(classes);
  const auto x = solve(drive, priors.geometry, priors.value);
  if (!x) return std::nullopt;
  DriveSolution solution;
  DriveVector& vector = solution.vector;
  vector.head<kUnknowns>() = *x;
  if (!drive.body.normal.isZero()) return solution;
  const CheckResiduals residuals = check_residuals(drive, *x, priors.geometry, priors.value);
  const auto fits = fit_forces(classes, *x, priors);
  for (int w = 0; w < kWheels; ++w) {
    const FirstOrderFit& fit = fits[static_cast<std::size_t>(w)];
    vector.segment<kWheelChecks>(kResiduals + kWheelChecks * w) = residuals.row(w).transpose();
    vector.segment<kForceParts>(kForces + kForceParts * w) << fit.unbalance_kg_m.real(),
        fit.unbalance_kg_m.imag(), fit.force_n.real(), fit.force_n.imag();
  }
  const BodyFit body = body_fit(drive, priors.geometry, priors.value);
  vector.tail<2>() = body.inertia_shares;
  solution.body_residual = body.residual;
  return solution;
}

struct Scatter {
  DriveMatrix covariance;
  Eigen::MatrixXd body_residual;  ///< [equation x group left out]
};
std::optional<Scatter> jackknife(const SpeedClasses& drive, const Priors& priors) {
  const std::vector<DriveMoments> classes = drive.totals();
  const std::vector<SpeedClasses::LeftOut> all = drive.left_out();
  std::vector<DriveVector> partial;
  Scatter scatter{.covariance = {}, .body_residual = Eigen::MatrixXd(kBodyEquations, std::ssize(all))};
  for (const SpeedClasses::LeftOut& left_out : all) {
    std::vector<DriveMoments> rest = classes;
    rest[left_out.which] = left_out.total;
    if (left_out.total.sections == 0) rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(left_out.which));
    const auto solution = solve_drive(rest, priors);
    if (!solution) return std::nullopt;
    scatter.body_residual.col(std::ssize(partial)) = solution->body_residual;
    partial.push_back(solution->vector);
  }
  scatter.covariance = jackknife_covariance(partial);
  return scatter;
}

/// Weight of a group's unbalances.
double unbalance_weight(const DriveMoments& group) {
  return group.harmonic.normal.trace().real() + group.body.normal.trace().real();
}

/// Parts of equal weight that would hold as much: fast driving shows more of the unbalances than slow.
double equal_parts(const Eigen::VectorXd& weight) {
  return weight.sum() * weight.sum() / weight.squaredNorm();
}

double equal_groups(const std::vector<DriveMoments>& groups) {
  Eigen::VectorXd weight(std::ssize(groups));
  for (Eigen::Index g = 0; g < weight.size(); ++g)
    weight(g) = unbalance_weight(groups[static_cast<std::size_t>(g)]);
  constexpr double kLeast = 4.0;  // below it the uncertainty has no bound
  return weight.squaredNorm() > 0.0 ? std::max(kLeast, equal_parts(weight)) : kLeast;
}

/// Scatter between drives.
struct BetweenDrives {
  /// How many times as large their variance is as that of their sections; 1 where drives do not determine it.
  DriveVector ratio = DriveVector::Ones();
  /// Factor of the variance: the part beyond the sections' rests on few drives only.
  DriveVector widening = DriveVector::Ones();
};

BetweenDrives compare(const DriveGroups& drives, const DriveVector& vector, const DriveMatrix& sections,
                      const Priors& priors) {
  const auto groups = static_cast<Eigen::Index>(drives.size());
  if (groups < 2) return {};
  Eigen::MatrixXd left_out(kDriveVector, groups);
  Eigen::VectorXd seconds(groups), weight(groups);
  for (Eigen::Index g = 0; g < groups; ++g) {
    const auto solution = solve_drive(drives.without(static_cast<std::size_t>(g)), priors);
    if (!solution) return {};  // all hangs on that drive: its sections are all there is
    const DriveMoments total = drives.total(static_cast<std::size_t>(g));
    left_out.col(g) = solution->vector;
    seconds(g) = total.seconds;
    weight(g) = unbalance_weight(total);
  }
  DriveVector ratio = variance_between(vector, left_out, seconds).cwiseQuotient(sections.diagonal());
  DriveVector factor = DriveVector::Constant(few_drives_factor(equal_parts(seconds)));
  if (weight.minCoeff() > 0.0) {
    const DriveVector of_wheels =
        variance_between(vector, left_out, weight).cwiseQuotient(sections.diagonal());
    const auto count_by_weight = [&, few = few_drives_factor(equal_parts(weight))](int at, int size) {
      ratio.segment(at, size) = of_wheels.segment(at, size);
      factor.segment(at, size).setConstant(few);
    };
    count_by_weight(kEstimatedUnbalance, 2 * kWheels);
    count_by_weight(kForces, kForceParts * kWheels);
  }
  const auto average_pair = [&ratio](int at) {
    ratio.segment<2>(at).setConstant(ratio.segment<2>(at).mean());
  };
  for (int w = 0; w < kWheels; ++w) {
    average_pair(kEstimatedUnbalance + 2 * w);
    average_pair(kForces + kForceParts * w);
    average_pair(kForces + kForceParts * w + 2);
  }
  ratio = ratio.unaryExpr([](double one) { return std::isfinite(one) ? one : 1.0; });
  return {ratio, (1.0 + (ratio.array() - 1.0).max(0.0) * factor.array()).matrix()};
}

/// Change of the result with the share of each known parameter, columns by parameter.
std::optional<Changes> per_share(const std::vector<DriveMoments>& classes, const DriveVector& vector,
                                 const Priors& priors) {
  Changes change;
  for (int p = 0; p < kSpring; ++p) {
    Priors changed = priors;
    changed.value(p) *= 1.0 + kStep;
    const auto then = solve_drive(classes, changed);
    if (!then) return std::nullopt;
    change.col(p) = (then->vector - vector) / kStep;
  }
  return change;
}

/// Influence of the tyres' dampers, which no drive determines, on the unknowns: those of an axle are wrong
/// alike.
bool add_tyre_dampers(const std::vector<DriveMoments>& classes, const DriveVector& vector,
                      const Priors& priors, EstimateCovariance& result) {
  for (int first = kTyreDamper; first < kTyreDamper + kWheels; first += 2) {
    if (priors.sigma(first) == 0.0) continue;
    Priors changed = priors;
    changed.value.segment<2>(first) += priors.sigma.segment<2>(first);
    const auto then = solve_drive(classes, changed);
    if (!then) return false;
    const UnknownVector change = (then->vector - vector).head<kUnknowns>();
    result.model += change * change.transpose();
  }
  return true;
}

void judge_wheels(const DriveVector& vector, const DriveMatrix& covariance, const Changes& change,
                  double groups, EstimateCovariance& result) {
  constexpr int kAll = kWheels * kWheelChecks;
  double information = 0.0;
  Eigen::Matrix<double, kAll, 1> gain = Eigen::Matrix<double, kAll, 1>::Zero();
  for (int w = 0; w < kWheels; ++w) {
    const int at = kResiduals + kWheelChecks * w;
    const Eigen::Vector2d grows = change.block<2, 1>(at, kWheelMass + w);
    const Eigen::Matrix2d scatter =
        covariance.block<2, 2>(at, at) + kPatchShare * kPatchShare * grows * grows.transpose();
    GoodnessOfFit& fit = result.fit[static_cast<std::size_t>(1 + w)];
    fit = goodness_of_fit(vector.segment<2>(at), scatter, grows, groups);
    if (fit.sigma_share == 0.0) return;
    const double weight = 1.0 / (fit.sigma_share * fit.sigma_share);
    information += weight;
    gain.segment<2>(kWheelChecks * w) = weight * fit.gain;
  }
  gain /= information;
  const auto among = covariance.block<kAll, kAll>(kResiduals, kResiduals);
  const double widen = few_groups_factor(groups);
  result.mass_share = gain.dot(vector.segment<kAll>(kResiduals));
  result.sigma_mass_share = std::sqrt(widen * gain.dot(among * gain) + kPatchShare * kPatchShare);
}

/// By the inertias that would fit better, and by whether any suspension fits at all.
void judge_body(const DriveSolution& solution, const Scatter& scatter, const Changes& change, double groups,
                EstimateCovariance& result) {
  const Eigen::Matrix2d of_inertias = scatter.covariance.bottomRightCorner<2, 2>() +
                                      kInertiaShare * kInertiaShare * Eigen::Matrix2d::Identity();
  GoodnessOfFit& fit = result.fit[0];
  fit = goodness_of_fit(solution.vector.tail<2>(), of_inertias, change.block<2, 1>(kInertias, kRollInertia),
                        groups);
  const double left = chance_of_residuals(solution.body_residual, scatter.body_residual, groups, kBodyShare);
  fit.chance = std::min(1.0, 2.0 * std::min(fit.chance, left));  // of two tests
}

void judge_forces(const DriveMatrix& covariance, double widen, EstimateCovariance& result) {
  for (int w = 0; w < kWheels; ++w) {
    const auto variance = [&](int part) {
      const int at = kForces + kForceParts * w + part;
      return widen * 0.5 * (covariance(at, at) + covariance(at + 1, at + 1));
    };
    FirstOrderFit& fit = result.first_order[static_cast<std::size_t>(w)];
    // Without some group there may be one speed only, which determines neither: then the whole hangs on that
    // group.
    if (!std::isfinite(variance(0))) {
      fit.separable = false;
      fit.sigma_unbalance_kg_m = fit.sigma_force_n = std::numeric_limits<double>::infinity();
      continue;
    }
    fit.sigma_unbalance_kg_m = std::sqrt(variance(0));
    fit.sigma_force_n = std::sqrt(variance(2));
  }
}

}  // namespace

Priors Priors::of(const VehicleConfig& vehicle) {
  Priors priors{geometry_of(vehicle.model), nominal_parameters(vehicle), ParameterVector::Zero(), {}};
  priors.sigma(kBodyMass) = vehicle.model.body_mass_sigma_kg;
  priors.sigma(kRollInertia) = vehicle.model.roll_inertia_sigma_kg_m2;
  priors.sigma(kPitchInertia) = vehicle.model.pitch_inertia_sigma_kg_m2;
  for (int i = 0; i < kWheels; ++i) {
    const WheelConfig& wheel = vehicle.wheel[static_cast<std::size_t>(i)];
    priors.sigma(kWheelMass + i) = wheel.mass_sigma_kg;
    priors.sigma(kTyreDamper + i) =
        vehicle.model.axle[static_cast<std::size_t>(i / 2)].tyre_damper_sigma_n_s_m;
    priors.rolling_radius_m(i) = wheel.rolling_radius_m;
  }
  return priors;
}

std::optional<EstimateCovariance> estimate_covariance(const SpeedClasses& drive, const Priors& priors,
                                                      const DriveGroups& drives) {
  const std::vector<DriveMoments> groups = drive.groups();
  if (groups.size() < 4) return std::nullopt;
  const std::vector<DriveMoments> classes = drive.totals();
  const auto solution = solve_drive(classes, priors);
  auto scatter = solution ? jackknife(drive, priors) : std::nullopt;
  if (!scatter) return std::nullopt;
  DriveMatrix& covariance = scatter->covariance;
  const BetweenDrives between = compare(drives, solution->vector, covariance, priors);
  const DriveVector widened = between.widening.cwiseSqrt();
  covariance = widened.asDiagonal() * covariance * widened.asDiagonal();
  const double equal = equal_groups(groups);
  const double widen = few_groups_factor(equal);
  EstimateCovariance result;
  result.drives_widening = between.widening.head<kUnknowns>();
  result.drive = widen * covariance.topLeftCorner<kUnknowns, kUnknowns>();
  result.model.setZero();
  for (int w = 0; w < kWheels; ++w)
    result.drives_ratio[static_cast<std::size_t>(w)] = between.ratio(kEstimatedUnbalance + 2 * w);
  const DriveMoments total = sum_of(classes);
  if (!total.body.normal.isZero()) return result;

  result.suspension = suspension_conditioning(total, priors.geometry, priors.value);
  const auto change = per_share(classes, solution->vector, priors);
  if (!change) return std::nullopt;
  const Eigen::Matrix<double, kUnknowns, kSpring> of_masses =
      change->topRows<kUnknowns>() *
      priors.sigma.head<kSpring>().cwiseQuotient(priors.value.head<kSpring>()).asDiagonal();
  result.model = of_masses * of_masses.transpose();
  if (!add_tyre_dampers(classes, solution->vector, priors, result)) return std::nullopt;
  judge_wheels(solution->vector, covariance, *change, equal, result);
  judge_body(*solution, *scatter, *change, equal, result);
  result.first_order = fit_forces(classes, solution->vector.head<kUnknowns>(), priors);
  judge_forces(covariance, widen, result);
  return result;
}

Eigen::VectorXd variance_between(const Eigen::VectorXd& whole, const Eigen::MatrixXd& left_out,
                                 const Eigen::VectorXd& weight) {
  const Eigen::VectorXd rest = 1.0 - (weight / weight.sum()).array();
  return (left_out.colwise() - whole).cwiseAbs2() * rest;
}

}  // namespace roadbalance
