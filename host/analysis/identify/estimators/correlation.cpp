#include "host/analysis/identify/estimators/correlation.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>
#include <string>

#include "common/vehicle/unbalance_response.hpp"

namespace roadbalance {
namespace {

constexpr double kNotEstimated = std::numeric_limits<double>::quiet_NaN();
constexpr double kLeastTurns = 1.0;  ///< |f_i - f_j| T that separates wheels

using Complex = std::complex<double>;

/// |f_i - f_j| T over the whole drive.
double turns_between(const BySpeed<LinePhasors>& drive, int i, int j) {
  double turned = 0.0;
  for (const auto& [key, sums] : drive.at) turned += std::abs(sums.turned_rad(i) - sums.turned_rad(j));
  return turned / (2.0 * std::numbers::pi);
}

bool has(const BySpeed<LinePhasors>& drive, int wheel) {
  for (const auto& [key, sums] : drive.at)
    if (sums.has(wheel)) return true;
  return false;
}

/// Acceleration of a wheel by its own unbalance of 1 kg m, Om^2 H.
Complex own_response(const LinearModel& model, const LinePhasors& sums, int wheel) {
  return unbalance_response(model, wheel, sums.omega()(wheel))(kBodyCoordinates + wheel);
}

Complex unbalance(const BySpeed<LinePhasors>& drive, const LinearModel& model, int wheel) {
  Complex with_response = 0.0;
  double power = 0.0;
  for (const auto& [key, sums] : drive.at) {
    if (!sums.has(wheel)) continue;
    const Complex h = own_response(model, sums, wheel);
    with_response += std::conj(h) * sums.Z(wheel, kBodyCoordinates + wheel);
    power += std::norm(h) * sums.C(wheel, wheel).real();
  }
  return power > 0.0 ? with_response / power : Complex(kNotEstimated, kNotEstimated);
}

}  // namespace

CorrelationEstimator::CorrelationEstimator(const Question& question)
    : question_(question),
      model_(linear_model(question.geometry, question.known)),
      correlator_(wheels_asked_for_unbalance(question.asked)) {}

void CorrelationEstimator::add(const Stretch& stretch) {
  correlator_.parts(stretch, [&](const LinePhasors& part) { sums_.add(stretch.speed_m_s, part); });
}

EstimatorAnswer CorrelationEstimator::solve() const {
  const BySpeed<LinePhasors> drive = sums_.all();
  const auto solve = [this](const BySpeed<LinePhasors>& part) -> std::optional<UnknownVector> {
    UnknownVector x = UnknownVector::Constant(kNotEstimated);
    for (int i = 0; i < kWheels; ++i) {
      const Complex U = unbalance(part, model_, i);
      x.segment<2>(kEstimatedUnbalance + 2 * i) << U.real(), U.imag();
    }
    return x;
  };
  EstimatorAnswer answer = sums_.solve(question_, solve);
  bool others = question_.asks_for_suspension();
  for (int i = 0; i < kWheels; ++i) others = others || question_.asks_for_tyre(i);
  if (others)
    answer.diagnostics.emplace_back("correlation tells unbalances alone: no springs, dampers and tyres");
  for (int i = 0; i < kWheels; ++i) {
    if (!question_.asks_for_unbalance(i)) continue;
    const std::string name = kWheelNames[static_cast<std::size_t>(i)];
    if (!has(drive, i)) {
      answer.diagnostics.push_back(name + ": no angle");
      continue;
    }
    for (int j = 0; j < kWheels; ++j) {
      if (j == i || !question_.asks_for_unbalance(j) || !has(drive, j)) continue;
      const double turns = turns_between(drive, i, j);
      if (turns >= kLeastTurns) continue;
      answer.x.segment<2>(kEstimatedUnbalance + 2 * i).setConstant(kNotEstimated);
      answer.covariance.middleRows<2>(kEstimatedUnbalance + 2 * i).setConstant(kNotEstimated);
      answer.covariance.middleCols<2>(kEstimatedUnbalance + 2 * i).setConstant(kNotEstimated);
      char sentence[160];
      std::snprintf(sentence, sizeof sentence,
                    "%s is not separated from %s: they differed by %.2f turns, 1 is needed", name.c_str(),
                    kWheelNames[static_cast<std::size_t>(j)], turns);
      answer.diagnostics.emplace_back(sentence);
    }
    remark_on_growth(drive, i, answer);
  }
  return answer;
}

/// Fits log |force| against log Om over the speeds, each weighted by its time.
void CorrelationEstimator::remark_on_growth(const BySpeed<LinePhasors>& drive, int wheel,
                                            EstimatorAnswer& answer) const {
  std::vector<Eigen::Vector3d> points;  // log Om, log |F|, standard deviation of that
  for (const auto& [key, sums] : drive.at) {
    if (!sums.has(wheel)) continue;
    const int row = kBodyCoordinates + wheel;
    const double om = sums.omega()(wheel), count = sums.C(wheel, wheel).real();
    const double size = std::abs(sums.Z(wheel, row)) / count;
    const double sigma = std::sqrt(sums.noise()(row, row).real() / (2.0 * count)) / size;
    points.emplace_back(std::log(om), std::log(size * om * om / std::abs(own_response(model_, sums, wheel))),
                        sigma);
  }
  if (points.size() < 2) return;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector2d row(1.0, p(0) - points.front()(0));
    normal += row * row.transpose() / (p(2) * p(2));
    right += row * p(1) / (p(2) * p(2));
  }
  const double exponent = normal.ldlt().solve(right)(1);
  const double sigma = std::sqrt(normal.inverse()(1, 1));
  if (!(std::abs(exponent - 2.0) > 2.0 * sigma)) return;
  char sentence[160];
  std::snprintf(sentence, sizeof sentence,
                "%s: its force grows with the speed to the power of %.1f ± %.1f: not an unbalance alone",
                kWheelNames[static_cast<std::size_t>(wheel)], exponent, sigma);
  answer.diagnostics.emplace_back(sentence);
}

std::vector<EstimatorKind> correlation_kinds() {
  return {{"correlation", "accelerations correlated with the wheels' angles, over the speeds", false,
           [](const Question& question) -> std::unique_ptr<Estimator> {
             return std::make_unique<CorrelationEstimator>(question);
           }}};
}

}  // namespace roadbalance
