#include "host/analysis/balance/check_weights.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <complex>

#include "common/text/format.hpp"

namespace roadbalance {
namespace {

/// 99 % quantile of chi^2 with two degrees of freedom, -2 ln 0.01.
constexpr double kChiSquared99 = 9.210340371976184;

Eigen::Vector2d components(std::complex<double> value) {
  return {value.real(), value.imag()};
}

Eigen::Vector2d unbalance_g(const Balance& balance) {
  return components(std::polar(balance.unbalance_g, balance.angle_rad));
}

std::complex<double> moment_g_m(const std::vector<WheelWeight>& weights) {
  std::complex<double> sum = 0.0;
  for (const WheelWeight& weight : weights) sum += weight.moment_g_m();
  return sum;
}

/// Standard deviation of a vector's length.
double sigma_of_length(const Eigen::Vector2d& vector, const Eigen::Matrix2d& covariance) {
  const double length = vector.norm();
  if (length == 0.0) return std::sqrt(covariance.trace());
  return std::sqrt(vector.dot(covariance * vector)) / length;
}

WeightPlacement placement(const WeightCheck& v) {
  const Eigen::Vector2d change = v.after_g - v.before_g;
  const Eigen::Matrix2d covariance = v.before_covariance_g2 + v.after_covariance_g2;
  const double fitting_g = kFitting * v.fitted_g.norm();
  const Eigen::LLT<Eigen::Matrix2d> drives(covariance);
  const Eigen::LLT<Eigen::Matrix2d> with_fitting(covariance +
                                                 fitting_g * fitting_g * Eigen::Matrix2d::Identity());
  const auto square = [](const auto& of, const Eigen::Vector2d& vector) {
    return vector.dot(of.solve(vector));
  };
  // A change within the uncertainty proves nothing.
  if (square(drives, v.fitted_g) <= kChiSquared99) return WeightPlacement::kNotJudged;
  const Eigen::Vector2d mirrored(v.fitted_g.x(), -v.fitted_g.y());
  if (square(with_fitting, change - v.fitted_g) <= kChiSquared99) return WeightPlacement::kAsWanted;
  if (square(drives, change) <= kChiSquared99) return WeightPlacement::kNoEffect;
  const double as_mirrored = square(with_fitting, change - mirrored);
  const double as_opposite = square(with_fitting, change + v.fitted_g);
  if (std::min(as_mirrored, as_opposite) > kChiSquared99) return WeightPlacement::kElsewhere;
  return as_mirrored <= as_opposite ? WeightPlacement::kMirrored : WeightPlacement::kOpposite;
}

WeightCheckVerdict verdict(const WeightCheck& v, const BalanceLimits& limits) {
  const double after_g = v.after_g.norm();
  if (std::sqrt(after_g * after_g + v.after_covariance_g2.trace()) <= limits.shop_g)
    return WeightCheckVerdict::kGood;
  const double more_g = after_g - v.before_g.norm();
  const double sigma_after_g = sigma_of_length(v.after_g, v.after_covariance_g2);
  const double sigma_g = std::hypot(sigma_after_g, sigma_of_length(v.before_g, v.before_covariance_g2));
  if (more_g < -2.0 * sigma_g) return WeightCheckVerdict::kLess;
  if (more_g > 2.0 * sigma_g) return WeightCheckVerdict::kMore;
  return sigma_after_g > limits.sigma_g ? WeightCheckVerdict::kOpen : WeightCheckVerdict::kUnchanged;
}

std::complex<double> fitted_between_g_m(const WheelConfig& before, const WheelConfig& after) {
  const std::complex<double> moment = moment_g_m(after.fitted) - moment_g_m(before.fitted);
  constexpr double kLeast_g_m = 1e-6;
  return std::abs(moment) > kLeast_g_m ? moment : 0.0;
}

void put_fitted(const BalancedDrive& before, const BalancedDrive& after, std::size_t w, WeightCheck& v) {
  const std::complex<double> by_files = fitted_between_g_m(before.vehicle.wheel[w], after.vehicle.wheel[w]);
  v.fitted_known = by_files != 0.0;
  const Compensation& advised = before.compensation[w];
  const std::complex<double> by_advice =
      advised.advice == Advice::kSteps ? advised.plan.applied_g_m : std::complex<double>();
  v.fitted_g = components(v.fitted_known ? by_files : by_advice) / v.weight_radius_m;
}

WeightCheck check_wheel(const BalancedDrive& before, const BalancedDrive& after, std::size_t w) {
  const Balance& now = after.balance[w];
  const Balance& then = before.balance[w];
  WeightCheck v{.wheel = static_cast<std::int32_t>(w),
                .time_ns = now.time_ns,
                .weight_radius_m = now.weight_radius_m,
                .text = before.name};
  if (std::string why = why_not_comparable(before.vehicle, after.vehicle, v.wheel); !why.empty()) {
    v.state = WeightCheckState::kNotComparable;
    v.text = std::move(why);
    return v;
  }
  if (then.state != Unknown::kNone) {
    v.state = WeightCheckState::kBeforeUnknown;
    return v;
  }
  const double scale = then.weight_radius_m / now.weight_radius_m;
  v.before_g = scale * unbalance_g(then);
  v.before_covariance_g2 = scale * scale * then.covariance_g2;
  put_fitted(before, after, w, v);
  if (now.state != Unknown::kNone) {
    v.state = WeightCheckState::kAfterUnknown;
    return v;
  }
  v.state = WeightCheckState::kKnown;
  v.after_g = unbalance_g(now);
  v.after_covariance_g2 = now.covariance_g2;
  const double length_before = v.before_g.norm(), length_after = v.after_g.norm();
  v.reduction = 1.0 - length_after / length_before;
  v.sigma_reduction =
      std::hypot(sigma_of_length(v.after_g, v.after_covariance_g2),
                 length_after / length_before * sigma_of_length(v.before_g, v.before_covariance_g2)) /
      length_before;
  v.verdict = verdict(v, after.vehicle.limits);
  v.placement = placement(v);
  return v;
}

}  // namespace

std::string why_not_comparable(const VehicleConfig& before, const VehicleConfig& after, int wheel) {
  const auto w = static_cast<std::size_t>(wheel);
  const WheelConfig &then = before.wheel[w], &now = after.wheel[w];
  if (before.name != after.name)
    return "the drive before was of another car, \"" + before.name + "\", this one is of \"" + after.name +
           "\"";
  // No file writes an angle to more digits.
  constexpr double kSameAngle_rad = 1e-9;
  if (std::abs(then.encoder.datum_rad - now.encoder.datum_rad) > kSameAngle_rad)
    return "its zero mark was thought to be elsewhere in the drive before (datum_deg): angles of the two do "
           "not "
           "compare; drive the one before again";
  if (then.encoder.pulses_per_turn != now.encoder.pulses_per_turn ||
      then.encoder.zero_mark != now.encoder.zero_mark || then.encoder.counter != now.encoder.counter ||
      then.encoder.steering_ratio != now.encoder.steering_ratio)
    return "its encoder is another one than in the drive before: angles of the two do not compare";
  if (then.mass_kg != now.mass_kg)
    return format("its mass_kg is %g now and was %g: grams of the two do not compare", now.mass_kg,
                  then.mass_kg);
  return "";
}

bool weights_were_fitted_between(const VehicleConfig& before, const VehicleConfig& after) {
  bool fitted = false;
  for (std::size_t w = 0; w < kWheels; ++w) {
    if (!why_not_comparable(before, after, static_cast<int>(w)).empty()) return false;
    fitted = fitted || fitted_between_g_m(before.wheel[w], after.wheel[w]) != 0.0;
  }
  return fitted;
}

std::array<WeightCheck, kWheels> check_weights(const BalancedDrive& before, const BalancedDrive& after) {
  std::array<WeightCheck, kWheels> result;
  for (std::size_t w = 0; w < kWheels; ++w) result[w] = check_wheel(before, after, w);
  return result;
}

std::array<WeightCheck, kWheels> reading_before(const std::string& name,
                                                const std::array<Balance, kWheels>& now) {
  std::array<WeightCheck, kWheels> result;
  for (std::size_t w = 0; w < kWheels; ++w)
    result[w] = {.wheel = static_cast<std::int32_t>(w), .time_ns = now[w].time_ns, .text = name};
  return result;
}

}  // namespace roadbalance
