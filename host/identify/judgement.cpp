#include "host/identify/judgement.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/identify/between_drives.hpp"
#include "host/identify/confidence.hpp"
#include "host/identify/speed_forces.hpp"

namespace roadbalance {
namespace {

/// One vector of all that a drive says: the unknowns, the wheels' residuals, unbalance and force of each
/// wheel, the shares by which the body's inertias seem wrong.
constexpr int kResiduals = kUnknowns;
constexpr int kForces = kResiduals + kWheels * kWheelChecks;
constexpr int kForceParts = 4;  ///< of a wheel: Re U, Im U, Re R, Im R
constexpr int kInertias = kForces + kForceParts * kWheels;
constexpr int kSaid = kInertias + 2;
using Said = Eigen::Matrix<double, kSaid, 1>;
using SaidMatrix = Eigen::Matrix<double, kSaid, kSaid>;
struct Told {
  Said said = Said::Zero();
  BodyColumn body_residual = BodyColumn::Zero();
};
using Changes = Eigen::Matrix<double, kSaid, kSpring>;

/// What the contact patch leaves of the road at the tyre's lag is as much of a wheel's mass.
constexpr double kPatchShare = 0.01;
/// What samples in place of a continuous record, and a car that no equation holds exactly, are of an inertia.
constexpr double kInertiaShare = 0.005;
/// The same of all that moves the body: twice what linear cars leave, 0.09 to 0.13 % on roads of class A and
/// B.
constexpr double kBodyShare = 0.002;
constexpr double kStep = 0.01;  ///< of a parameter, for differences

std::array<FirstOrderFit, kWheels> fit_forces(const std::vector<DriveMoments>& classes,
                                              const UnknownVector& x, const Known& known) {
  std::array<std::vector<FirstOrderForce>, kWheels> forces;
  for (const SpeedForces& speed : drive_forces(classes, x, known).speed)
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

std::optional<Told> tell(const std::vector<DriveMoments>& classes, const Known& known) {
  const DriveMoments drive = sum_of(classes);
  const auto x = solve(drive, known.geometry, known.value);
  if (!x) return std::nullopt;
  Told told;
  Said& said = told.said;
  said.head<kUnknowns>() = *x;
  if (!drive.body.normal.isZero()) return told;
  const CheckResiduals residuals = check_residuals(drive, *x, known.geometry, known.value);
  const auto fits = fit_forces(classes, *x, known);
  for (int w = 0; w < kWheels; ++w) {
    const FirstOrderFit& fit = fits[static_cast<std::size_t>(w)];
    said.segment<kWheelChecks>(kResiduals + kWheelChecks * w) = residuals.row(w).transpose();
    said.segment<kForceParts>(kForces + kForceParts * w) << fit.unbalance_kg_m.real(),
        fit.unbalance_kg_m.imag(), fit.force_n.real(), fit.force_n.imag();
  }
  const BodyFit body = body_fit(drive, known.geometry, known.value);
  said.tail<2>() = body.inertia_shares;
  told.body_residual = body.residual;
  return told;
}

struct Scatter {
  SaidMatrix covariance;
  Eigen::MatrixXd body_residual;  ///< [equation x group left out]
};
std::optional<Scatter> jackknife(const SpeedClasses& drive, const Known& known) {
  const std::vector<DriveMoments> classes = drive.totals();
  const std::vector<SpeedClasses::LeftOut> all = drive.left_out();
  std::vector<Said> partial;
  Scatter scatter{.covariance = {}, .body_residual = Eigen::MatrixXd(kBodyEquations, std::ssize(all))};
  for (const SpeedClasses::LeftOut& left_out : all) {
    std::vector<DriveMoments> rest = classes;
    rest[left_out.which] = left_out.total;
    if (left_out.total.sections == 0) rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(left_out.which));
    const auto told = tell(rest, known);
    if (!told) return std::nullopt;
    scatter.body_residual.col(std::ssize(partial)) = told->body_residual;
    partial.push_back(told->said);
  }
  scatter.covariance = jackknife_covariance(partial);
  return scatter;
}

/// What the unbalances of a group weigh.
double unbalance_weight(const DriveMoments& group) {
  return group.harmonic.normal.trace().real() + group.body.normal.trace().real();
}

/// Parts of equal weight that would tell as much: fast driving tells more of the unbalances than slow.
double equal_parts(const Eigen::VectorXd& weight) {
  return weight.sum() * weight.sum() / weight.squaredNorm();
}

double equal_groups(const std::vector<DriveMoments>& groups) {
  Eigen::VectorXd weight(std::ssize(groups));
  for (Eigen::Index g = 0; g < weight.size(); ++g)
    weight(g) = unbalance_weight(groups[static_cast<std::size_t>(g)]);
  constexpr double kLeast = 4.0;  // below it there is no end to the doubt
  return weight.squaredNorm() > 0.0 ? std::max(kLeast, equal_parts(weight)) : kLeast;
}

/// What drives are to one another.
struct BetweenDrives {
  /// How many times as large their variance is as that of their sections; 1 where drives do not tell.
  Said ratio = Said::Ones();
  /// Of the variance: what of it the sections do not tell rests on so many drives only.
  Said widening = Said::Ones();
};

BetweenDrives compare(const DriveGroups& drives, const Said& said, const SaidMatrix& sections,
                      const Known& known) {
  const auto groups = static_cast<Eigen::Index>(drives.size());
  if (groups < 2) return {};
  Eigen::MatrixXd left_out(kSaid, groups);
  Eigen::VectorXd seconds(groups), weight(groups);
  for (Eigen::Index g = 0; g < groups; ++g) {
    const auto told = tell(drives.without(static_cast<std::size_t>(g)), known);
    if (!told) return {};  // all hangs on that drive: its sections are all there is
    const DriveMoments total = drives.total(static_cast<std::size_t>(g));
    left_out.col(g) = told->said;
    seconds(g) = total.seconds;
    weight(g) = unbalance_weight(total);
  }
  Said ratio = variance_between(said, left_out, seconds).cwiseQuotient(sections.diagonal());
  Said factor = Said::Constant(few_drives_factor(equal_parts(seconds)));
  if (weight.minCoeff() > 0.0) {
    const Said of_wheels = variance_between(said, left_out, weight).cwiseQuotient(sections.diagonal());
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

/// How what is said changes with the share of each known parameter, columns by parameter.
std::optional<Changes> per_share(const std::vector<DriveMoments>& classes, const Said& said,
                                 const Known& known) {
  Changes change;
  for (int p = 0; p < kSpring; ++p) {
    Known changed = known;
    changed.value(p) *= 1.0 + kStep;
    const auto then = tell(classes, changed);
    if (!then) return std::nullopt;
    change.col(p) = (then->said - said) / kStep;
  }
  return change;
}

/// What the tyres' dampers do to the unknowns, which no drive tells: those of an axle are wrong alike.
bool add_tyre_dampers(const std::vector<DriveMoments>& classes, const Said& said, const Known& known,
                      Judgement& judgement) {
  for (int first = kTyreDamper; first < kTyreDamper + kWheels; first += 2) {
    if (known.sigma(first) == 0.0) continue;
    Known changed = known;
    changed.value.segment<2>(first) += known.sigma.segment<2>(first);
    const auto then = tell(classes, changed);
    if (!then) return false;
    const UnknownVector change = (then->said - said).head<kUnknowns>();
    judgement.model += change * change.transpose();
  }
  return true;
}

void judge_wheels(const Said& said, const SaidMatrix& covariance, const Changes& change, double groups,
                  Judgement& judgement) {
  constexpr int kAll = kWheels * kWheelChecks;
  double information = 0.0;
  Eigen::Matrix<double, kAll, 1> gain = Eigen::Matrix<double, kAll, 1>::Zero();
  for (int w = 0; w < kWheels; ++w) {
    const int at = kResiduals + kWheelChecks * w;
    const Eigen::Vector2d grows = change.block<2, 1>(at, kWheelMass + w);
    const Eigen::Matrix2d scatter =
        covariance.block<2, 2>(at, at) + kPatchShare * kPatchShare * grows * grows.transpose();
    Misfit& misfit = judgement.misfit[static_cast<std::size_t>(1 + w)];
    misfit = judge_misfit(said.segment<2>(at), scatter, grows, groups);
    if (misfit.sigma_share == 0.0) return;
    const double weight = 1.0 / (misfit.sigma_share * misfit.sigma_share);
    information += weight;
    gain.segment<2>(kWheelChecks * w) = weight * misfit.gain;
  }
  gain /= information;
  const auto among = covariance.block<kAll, kAll>(kResiduals, kResiduals);
  const double widen = few_groups_factor(groups);
  judgement.mass_share = gain.dot(said.segment<kAll>(kResiduals));
  judgement.sigma_mass_share = std::sqrt(widen * gain.dot(among * gain) + kPatchShare * kPatchShare);
}

/// By the inertias that would fit better, and by whether any suspension fits at all.
void judge_body(const Told& told, const Scatter& scatter, const Changes& change, double groups,
                Judgement& judgement) {
  const Eigen::Matrix2d of_inertias = scatter.covariance.bottomRightCorner<2, 2>() +
                                      kInertiaShare * kInertiaShare * Eigen::Matrix2d::Identity();
  Misfit& misfit = judgement.misfit[0];
  misfit =
      judge_misfit(told.said.tail<2>(), of_inertias, change.block<2, 1>(kInertias, kRollInertia), groups);
  const double left = chance_of_residuals(told.body_residual, scatter.body_residual, groups, kBodyShare);
  misfit.chance = std::min(1.0, 2.0 * std::min(misfit.chance, left));  // of two tests
}

void judge_forces(const SaidMatrix& covariance, double widen, Judgement& judgement) {
  for (int w = 0; w < kWheels; ++w) {
    const auto variance = [&](int part) {
      const int at = kForces + kForceParts * w + part;
      return widen * 0.5 * (covariance(at, at) + covariance(at + 1, at + 1));
    };
    FirstOrderFit& fit = judgement.first_order[static_cast<std::size_t>(w)];
    // Without some group there may be one speed only, which tells neither: then the whole hangs on that
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

Known Known::of(const VehicleConfig& vehicle) {
  Known known{geometry_of(vehicle.model), nominal_parameters(vehicle), ParameterVector::Zero(), {}};
  known.sigma(kBodyMass) = vehicle.model.body_mass_sigma_kg;
  known.sigma(kRollInertia) = vehicle.model.roll_inertia_sigma_kg_m2;
  known.sigma(kPitchInertia) = vehicle.model.pitch_inertia_sigma_kg_m2;
  for (int i = 0; i < kWheels; ++i) {
    const WheelConfig& wheel = vehicle.wheel[static_cast<std::size_t>(i)];
    known.sigma(kWheelMass + i) = wheel.mass_sigma_kg;
    known.sigma(kTyreDamper + i) =
        vehicle.model.axle[static_cast<std::size_t>(i / 2)].tyre_damper_sigma_n_s_m;
    known.rolling_radius_m(i) = wheel.rolling_radius_m;
  }
  return known;
}

std::optional<Judgement> judge(const SpeedClasses& drive, const Known& known, const DriveGroups& drives) {
  const std::vector<DriveMoments> groups = drive.groups();
  if (groups.size() < 4) return std::nullopt;
  const std::vector<DriveMoments> classes = drive.totals();
  const auto told = tell(classes, known);
  auto scatter = told ? jackknife(drive, known) : std::nullopt;
  if (!scatter) return std::nullopt;
  SaidMatrix& covariance = scatter->covariance;
  const BetweenDrives between = compare(drives, told->said, covariance, known);
  const Said widened = between.widening.cwiseSqrt();
  covariance = widened.asDiagonal() * covariance * widened.asDiagonal();
  const double equal = equal_groups(groups);
  const double widen = few_groups_factor(equal);
  Judgement judgement;
  judgement.drive = widen * covariance.topLeftCorner<kUnknowns, kUnknowns>();
  judgement.model.setZero();
  for (int w = 0; w < kWheels; ++w)
    judgement.drives_ratio[static_cast<std::size_t>(w)] = between.ratio(kEstimatedUnbalance + 2 * w);
  const DriveMoments total = sum_of(classes);
  if (!total.body.normal.isZero()) return judgement;

  judgement.suspension = suspension_conditioning(total, known.geometry, known.value);
  const auto change = per_share(classes, told->said, known);
  if (!change) return std::nullopt;
  const Eigen::Matrix<double, kUnknowns, kSpring> of_masses =
      change->topRows<kUnknowns>() *
      known.sigma.head<kSpring>().cwiseQuotient(known.value.head<kSpring>()).asDiagonal();
  judgement.model = of_masses * of_masses.transpose();
  if (!add_tyre_dampers(classes, told->said, known, judgement)) return std::nullopt;
  judge_wheels(told->said, covariance, *change, equal, judgement);
  judge_body(*told, *scatter, *change, equal, judgement);
  judgement.first_order = fit_forces(classes, told->said.head<kUnknowns>(), known);
  judge_forces(covariance, widen, judgement);
  return judgement;
}

}  // namespace roadbalance
