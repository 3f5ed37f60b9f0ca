#include "host/analysis/identify/estimators/posterior.hpp"

#include <cmath>
#include <complex>
#include <memory>

#include "common/config/section.hpp"
#include "common/text/format.hpp"
#include "common/types/angle_units.hpp"
#include "host/analysis/identify/estimators/grouped.hpp"

namespace roadbalance {
namespace {

const CarPrior& prior_of(const Question& question) {
  if (!question.prior)
    throw ConfigError("estimator posterior: nothing is said of how well the car and its sensors are known");
  return *question.prior;
}

double size_sigma(std::complex<double> phasor, const Eigen::Matrix2d& covariance) {
  const Eigen::Vector2d along = Eigen::Vector2d(phasor.real(), phasor.imag()).normalized();
  return std::sqrt(along.dot(covariance * along));
}

}  // namespace

Posterior::Posterior(const Question& question) : question_(question), drive_(prior_of(question)) {}

EstimatorAnswer Posterior::solve() const {
  const auto car = drive_.solve();
  if (!car) {
    EstimatorAnswer none = judged(question_, std::nullopt, std::nullopt);
    none.diagnostics.emplace_back("the drive does not determine the car: its posterior has no clear mode");
    return none;
  }
  UnknownVector x;
  x.head<kEstimatedUnbalance>() = car->parameters.segment<kEstimatedUnbalance>(kSpring);
  UnknownMatrix covariance = UnknownMatrix::Zero();
  covariance.diagonal().head<kEstimatedUnbalance>() =
      car->sigma.segment<kEstimatedUnbalance>(kSpring).cwiseAbs2();
  std::vector<std::string> sentences;
  for (int i = 0; i < kWheels; ++i) {
    const WheelFirstOrder& wheel = car->wheel[static_cast<std::size_t>(i)];
    const int at = kEstimatedUnbalance + 2 * i;
    x.segment<2>(at) << wheel.correction_kg_m.real(), wheel.correction_kg_m.imag();
    covariance.block<2, 2>(at, at) = wheel.correction_covariance;
    if (!std::isfinite(std::abs(wheel.correction_kg_m))) continue;
    sentences.push_back(format("%s: tyre's force %.0f ± %.0f N; unbalance alone %.2f ± %.2f g m at %.0f°",
                               kWheelNames[static_cast<std::size_t>(i)], std::abs(wheel.force_n),
                               size_sigma(wheel.force_n, wheel.force_covariance),
                               1e3 * std::abs(wheel.unbalance_kg_m),
                               1e3 * size_sigma(wheel.unbalance_kg_m, wheel.unbalance_covariance),
                               std::arg(wheel.unbalance_kg_m) * kDegrees));
  }
  if (car->cut_s >= 1.0)
    sentences.push_back(format("%.0f s are left out for what joints and potholes shook", car->cut_s));
  EstimatorAnswer answer = judged(question_, x, covariance);
  answer.diagnostics.insert(answer.diagnostics.end(), sentences.begin(), sentences.end());
  return answer;
}

std::vector<EstimatorKind> posterior_kinds() {
  return {{"posterior", "one likelihood over car, sensors, road and forces, the road's shape free", false,
           [](const Question& question) -> std::unique_ptr<Estimator> {
             return std::make_unique<Posterior>(question);
           },
           true}};
}

}  // namespace roadbalance
