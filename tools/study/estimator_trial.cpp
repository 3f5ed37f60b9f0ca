#include "tools/study/estimator_trial.hpp"

#include <algorithm>
#include <cmath>

#include "common/config/section.hpp"
#include "common/types/angle_units.hpp"
#include "embedded/demo_vehicle.hpp"
#include "sim/drawn_car.hpp"
#include "tools/study/statistics.hpp"
#include "tools/views/number_json.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;

}  // namespace

CarTruth truth_of(const IdealDrive& drive, std::uint64_t seed, const VehicleConfig& vehicle) {
  const sim::DrawnCar car = sim::draw_car(drive.scenario, seed, vehicle);
  CarTruth truth{car.parameters, {}};
  for (std::size_t w = 0; w < kWheels; ++w) truth.unbalance_kg_m[w] = car.wheel[w].unbalance_kg_m;
  return truth;
}

std::vector<Stretch> shortened(std::span<const Stretch> stretches, Eigen::Index samples) {
  std::vector<Stretch> result;
  for (const Stretch& stretch : stretches) {
    Stretch first{stretch.rate_hz, stretch.speed_m_s, stretch.omega, {}, {}, {}};
    first.signals = stretch.signals.leftCols(std::min(samples, stretch.signals.cols()));
    first.readings = stretch.readings.leftCols(std::min(samples, stretch.readings.cols()));
    first.road_m = stretch.road_m.leftCols(std::min(samples, stretch.road_m.cols()));
    result.push_back(std::move(first));
  }
  return result;
}

EstimatorAnswer ask(const EstimatorKind& kind, const Question& question, const CarTruth& truth,
                    std::span<const Stretch> stretches) {
  Question put = question;
  if (kind.name == "known-tyre") put.known.segment<kWheels>(kTyre) = truth.parameters.segment<kWheels>(kTyre);
  const std::unique_ptr<Estimator> estimator = kind.make(put);
  for (const Stretch& stretch : stretches) estimator->add(stretch);
  return estimator->solve();
}

nlohmann::ordered_json errors_of(const EstimatorAnswer& answer, const CarTruth& truth, int wheel) {
  const int tyre = kEstimatedTyre + wheel, re = kEstimatedUnbalance + 2 * wheel;
  const double true_tyre = truth.parameters(kTyre + wheel);
  const Complex U0 = truth.unbalance_kg_m[static_cast<std::size_t>(wheel)];
  const Complex U(answer.x(re), answer.x(re + 1));
  nlohmann::ordered_json errors{
      {"tyre_percent", number_or_null(100.0 * (answer.x(tyre) / true_tyre - 1.0))},
      {"tyre_sigma_percent", number_or_null(100.0 * std::sqrt(answer.covariance(tyre, tyre)) / true_tyre)},
      {"residual_kg_m", number_or_null(std::abs(U - U0))}};
  if (U0 == 0.0) return errors;
  const Complex part = U / U0;
  errors["mass_percent"] = number_or_null(100.0 * (std::abs(part) - 1.0));
  errors["angle_deg"] = number_or_null(std::arg(part) * kDegrees);
  errors["re_percent"] = number_or_null(100.0 * (part.real() - 1.0));
  errors["im_percent"] = number_or_null(100.0 * part.imag());
  // Covariance of U / U0, whose first axis is the mass and whose second the angle.
  Eigen::Matrix2d turn;
  turn << U0.real(), U0.imag(), -U0.imag(), U0.real();
  turn /= std::norm(U0);
  const Eigen::Matrix2d covariance = turn * answer.covariance.block<2, 2>(re, re) * turn.transpose();
  errors["mass_sigma_percent"] = number_or_null(100.0 * std::sqrt(covariance(0, 0)));
  errors["angle_sigma_deg"] = number_or_null(std::sqrt(covariance(1, 1)) * kDegrees);
  return errors;
}

std::vector<EstimatorKind> chosen_estimators(const std::string& names) {
  const auto all = estimators();
  std::vector<EstimatorKind> result;
  if (names.empty()) return {all.begin(), all.end()};
  for (std::size_t begin = 0; begin <= names.size();) {
    const std::size_t end = std::min(names.find(',', begin), names.size());
    const std::string name = names.substr(begin, end - begin);
    const auto found = std::find_if(all.begin(), all.end(), [&](const auto& k) { return k.name == name; });
    if (found == all.end()) make_estimator(name, Question{});  // throws, with the names there are
    result.push_back(*found);
    begin = end + 1;
  }
  return result;
}

VehicleConfig demo_vehicle() {
  return VehicleConfig::parse(std::string(embedded::kDemoVehicle), "sim/demo/vehicle.toml");
}

sim::Scenario plain_scenario(const VehicleConfig& vehicle) {
  sim::Scenario scenario = sim::Scenario::read("", vehicle);
  scenario.parameter_spread = 0.0;
  scenario.wheel = {};
  return scenario;
}

std::vector<double> speeds_between(double low_km_h, double high_km_h, int n) {
  std::vector<double> speeds;
  for (int i = 0; i < n; ++i)
    speeds.push_back((low_km_h + (high_km_h - low_km_h) * i / std::max(1, n - 1)) / 3.6);
  return speeds;
}

}  // namespace roadbalance
