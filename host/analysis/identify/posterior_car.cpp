#include "host/analysis/identify/posterior_car.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

namespace roadbalance {
namespace {

/// Of a search whose place only makes the struts' linear elements: twice what J gains, a step of a standard
/// deviation.
constexpr double kRoughly = 1.0;

std::vector<SpeedOnRoad> speeds_of(const std::vector<PosteriorSums>& drives) {
  std::vector<SpeedOnRoad> all;
  int road = 0;
  for (const PosteriorSums& drive : drives) {
    for (const auto& [key, speed] : drive.speed)
      if (speed.spectra.segments > 0.0) all.push_back({&speed.spectra, road});
    ++road;
  }
  return all;
}

}  // namespace

SolvedCar::SolvedCar(const CarPrior& prior, std::vector<PosteriorSums> drives)
    : drives_(std::move(drives)),
      car_(prior, speeds_of(drives_)),
      mode_(posterior_mode(car_, Eigen::VectorXd::Zero(car_.size()), kRoughly)) {
  car_.linearise_struts(mode_.v);
  mode_ = posterior_mode(car_, mode_.v);
}

std::optional<PosteriorCar> SolvedCar::with(std::span<const LineMoments> lines) const {
  if (!mode_.converged) return std::nullopt;
  const UnbalancePosterior heard = unbalance_posterior(car_, mode_, lines);
  Eigen::VectorXd v = mode_.v;
  v.head(car_.known()) = heard.v;
  PosteriorCar result{.parameters = car_.parameters(v),
                      .sigma = ParameterVector::Zero(),
                      .deviations = {},
                      .wheel = heard.wheel};
  const std::vector<UncertainQuantity> quantities = car_.quantities();
  for (std::size_t a = 0; a < quantities.size(); ++a) {
    const auto at = static_cast<Eigen::Index>(a);
    const double variance = heard.covariance(at, at);
    // Of the prior's variance: what the drive hardly tells of follows the model's own small faults.
    constexpr double kLeastTold = 0.1;
    Deviation deviation = measured(quantities[a], v, std::sqrt(variance));
    deviation.sigmas = v(at) / std::sqrt(std::max(kLeastTold, 1.0 - variance));
    if (quantities[a].kind == UncertainQuantity::Kind::kParameter)
      result.sigma(quantities[a].index) = deviation.sigma;
    result.deviations.push_back(deviation);
  }
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(car_.known()), gain = mass;
  for (std::size_t a = 0; a < quantities.size(); ++a) {
    const auto& [kind, index] = quantities[a];
    const auto at = static_cast<Eigen::Index>(a);
    if (kind == UncertainQuantity::Kind::kGain)
      gain(at) = car_.prior().gain_sigma(index) / static_cast<double>(car_.channels());
    if (kind == UncertainQuantity::Kind::kParameter && index >= kWheelMass && index < kWheelMass + kWheels)
      mass(at) = car_.prior().sigma(index) / kWheels;
  }
  result.mass_scale_sigma = std::sqrt(mass.dot(heard.covariance * mass));
  result.gain_scale_sigma = std::sqrt(gain.dot(heard.covariance * gain));
  return result;
}

/// @param sigma  in standard deviations of the prior
Deviation SolvedCar::measured(const UncertainQuantity& of, const Eigen::VectorXd& v, double sigma) const {
  using Kind = UncertainQuantity::Kind;
  const CarPrior& prior = car_.prior();
  const auto share = [sigma](double value, double prior_sigma) { return sigma * prior_sigma * value; };
  switch (of.kind) {
    case Kind::kParameter: {
      const double value = car_.parameters(v)(of.index), by = prior.sigma(of.index);
      return {of, value, of.index >= kTyreDamper ? sigma * by : share(value, by), 0.0};
    }
    case Kind::kGain: {
      const double value = car_.gains(v)(of.index);
      return {of, value, share(value, prior.gain_sigma(of.index)), 0.0};
    }
    case Kind::kFriction:
      return {of, car_.friction_n(v)(of.index), sigma * prior.friction_sigma_n, 0.0};
    case Kind::kRebound:
      return {of, car_.rebound(v)(of.index), sigma * prior.rebound_sigma, 0.0};
    case Kind::kBracket:
      return {of, car_.brackets_s2(v)(of.index), sigma * prior.bracket_sigma_s2, 0.0};
    case Kind::kStruts:
      break;
  }
  const double factor = car_.strut_factor(v);
  return {of, factor, share(factor, prior.strut_sigma), 0.0};
}

UnknownVector PosteriorCar::unknowns() const {
  UnknownVector x;
  x.head<kEstimatedUnbalance>() = parameters.segment<kEstimatedUnbalance>(kSpring);
  for (int i = 0; i < kWheels; ++i) {
    const std::complex<double> correction = wheel[static_cast<std::size_t>(i)].correction_kg_m;
    x.segment<2>(kEstimatedUnbalance + 2 * i) << correction.real(), correction.imag();
  }
  return x;
}

}  // namespace roadbalance
