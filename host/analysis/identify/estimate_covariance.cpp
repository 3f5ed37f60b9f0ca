#include "host/analysis/identify/estimate_covariance.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/analysis/identify/confidence.hpp"

namespace roadbalance {
namespace {

DriveMoments sum_of(const std::vector<DriveMoments>& classes) {
  DriveMoments sum;
  for (const DriveMoments& total : classes) sum += total;
  return sum;
}

std::optional<UnknownVector> solve_drive(const std::vector<DriveMoments>& classes, const Priors& priors) {
  return solve(sum_of(classes), priors.geometry, priors.value);
}

std::optional<UnknownMatrix> jackknife(const SpeedClasses& drive, const Priors& priors) {
  const std::vector<DriveMoments> classes = drive.totals();
  std::vector<UnknownVector> partial;
  for (const SpeedClasses::LeftOut& left_out : drive.left_out()) {
    std::vector<DriveMoments> rest = classes;
    rest[left_out.which] = left_out.total;
    const auto x = solve_drive(rest, priors);
    if (!x) return std::nullopt;
    partial.push_back(*x);
  }
  return jackknife_covariance(partial);
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
  UnknownVector ratio = UnknownVector::Ones();
  /// Factor of the variance: the part beyond the sections' rests on few drives only.
  UnknownVector widening = UnknownVector::Ones();
};

BetweenDrives compare(const DriveGroups& drives, const UnknownVector& x, const UnknownMatrix& sections,
                      const Priors& priors) {
  const auto groups = static_cast<Eigen::Index>(drives.size());
  if (groups < 2) return {};
  Eigen::MatrixXd left_out(kUnknowns, groups);
  Eigen::VectorXd seconds(groups), weight(groups);
  for (Eigen::Index g = 0; g < groups; ++g) {
    const auto without = solve_drive(drives.without(static_cast<std::size_t>(g)), priors);
    if (!without) return {};  // all hangs on that drive: its sections are all there is
    const DriveMoments total = drives.total(static_cast<std::size_t>(g));
    left_out.col(g) = *without;
    seconds(g) = total.seconds;
    weight(g) = unbalance_weight(total);
  }
  UnknownVector ratio = variance_between(x, left_out, seconds).cwiseQuotient(sections.diagonal());
  UnknownVector factor = UnknownVector::Constant(few_drives_factor(equal_parts(seconds)));
  if (weight.minCoeff() > 0.0) {
    const UnknownVector of_wheels = variance_between(x, left_out, weight).cwiseQuotient(sections.diagonal());
    ratio.tail<2 * kWheels>() = of_wheels.tail<2 * kWheels>();
    factor.tail<2 * kWheels>().setConstant(few_drives_factor(equal_parts(weight)));
  }
  for (int w = 0; w < kWheels; ++w) {
    auto both = ratio.segment<2>(kEstimatedUnbalance + 2 * w);
    both.setConstant(both.mean());
  }
  ratio = ratio.unaryExpr([](double one) { return std::isfinite(one) ? one : 1.0; });
  return {ratio, (1.0 + (ratio.array() - 1.0).max(0.0) * factor.array()).matrix()};
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
  const auto x = solve_drive(drive.totals(), priors);
  const auto sections = x ? jackknife(drive, priors) : std::nullopt;
  if (!sections) return std::nullopt;
  const BetweenDrives between = compare(drives, *x, *sections, priors);
  const UnknownVector widened = (few_groups_factor(equal_groups(groups)) * between.widening).cwiseSqrt();
  EstimateCovariance result;
  result.drive = widened.asDiagonal() * *sections * widened.asDiagonal();
  result.drives_widening = between.widening;
  for (int w = 0; w < kWheels; ++w)
    result.drives_ratio[static_cast<std::size_t>(w)] = between.ratio(kEstimatedUnbalance + 2 * w);
  return result;
}

Eigen::VectorXd variance_between(const Eigen::VectorXd& whole, const Eigen::MatrixXd& left_out,
                                 const Eigen::VectorXd& weight) {
  const Eigen::VectorXd rest = 1.0 - (weight / weight.sum()).array();
  return (left_out.colwise() - whole).cwiseAbs2() * rest;
}

}  // namespace roadbalance
