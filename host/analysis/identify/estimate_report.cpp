#include "host/analysis/identify/estimate_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "common/config/section.hpp"
#include "common/vehicle/sensor_map.hpp"
#include "host/analysis/identify/body_instrument.hpp"
#include "host/analysis/identify/extra_variance.hpp"
#include "host/analysis/identify/missing_angle.hpp"
#include "host/analysis/identify/publish_estimate.hpp"
#include "host/analysis/identify/refusal.hpp"
#include "host/analysis/identify/signals.hpp"

namespace roadbalance {
namespace {

/// Nothing: the sensors do not show every wheel's motion.
std::optional<CarPrior> prior_of_car(const VehicleConfig& vehicle) {
  try {
    return CarPrior::of(vehicle);
  } catch (const ConfigError&) {
    return std::nullopt;
  }
}

/// True if the sensors show the body's motion.
bool shows_body(const VehicleConfig& vehicle) {
  try {
    SensorMap::of_body(vehicle);
    return true;
  } catch (const ConfigError&) {
    return false;
  }
}

/// Wheels that turned in step, and what to do about it; empty: none.
std::string in_step_sentence(const PhaseDrift& drift) {
  std::string sentence;
  for (int a = 0; a < kWheels; ++a)
    for (int b = a + 1; b < kWheels; ++b) {
      const auto between = drift.drift_rad(a, b);
      if (!between || *between >= kLeastDrift_rad) continue;
      sentence += (sentence.empty() ? "" : ", ") + std::string(kWheelNames[static_cast<std::size_t>(a)]) +
                  " and " + kWheelNames[static_cast<std::size_t>(b)] + " turned in step (" +
                  std::to_string(std::lround(*between * 180.0 / std::numbers::pi)) + " deg of drift)";
    }
  if (sentence.empty()) return sentence;
  return sentence +
         ": the body does not tell their unbalances apart; take a bend or change lanes so that they turn "
         "against one "
         "another, or fit sensors to their carriers";
}

}  // namespace

EstimateReport::EstimateReport(const VehicleConfig& vehicle)
    : vehicle_(vehicle),
      priors_(Priors::of(vehicle)),
      prior_(prior_of_car(vehicle)),
      body_only_(!prior_ && shows_body(vehicle)),
      of_vehicle_(why_no_angle(vehicle)) {
  if (body_only_)
    of_vehicle_ +=
        std::string(of_vehicle_.empty() ? "" : "; ") +
        "no vertical sensor shows the carrier of some wheel: unbalances come from the body alone, with "
        "springs, dampers and tyres as vehicle.toml has them";
  estimate_.identification.least_speed_m_s = vehicle.drive.least_speed_m_s;
  estimate_.identification.seconds_needed = kLeastSections * vehicle.drive.section_s;
  for (int i = 0; i < kWheels; ++i) estimate_.balance[static_cast<std::size_t>(i)].wheel = i;
  const bool angle =
      std::any_of(vehicle.wheel.begin(), vehicle.wheel.end(), [](const auto& w) { return !w.node.empty(); });
  unknown(angle ? Unknown::kTooShort : Unknown::kNoReference);
}

void EstimateReport::unfit(const std::string& why) {
  of_vehicle_ = why + (of_vehicle_.empty() ? "" : "; " + of_vehicle_);
  unknown(Unknown::kUnfitVehicle);
}

std::string EstimateReport::refusal(const PhaseDrift& drift) const {
  const std::string refused = body_only_ ? in_step_sentence(drift) : refusal_;
  return of_vehicle_ + (of_vehicle_.empty() || refused.empty() ? "" : "; ") + refused;
}

void EstimateReport::draw(const SpeedClasses& drive, const std::optional<PosteriorCar>& car,
                          const PhaseDrift& drift, std::int64_t time_ns, const DriveGroups& drives) {
  if (drive.empty()) return;
  describe(drive, drift, time_ns);
  if (drive.total().sections < kLeastSections) return unknown(Unknown::kTooShort);
  if (body_only_) return draw_body(drive, drift, drives);
  refusal_ = roadbalance::refusal(car, *prior_, vehicle_);
  remarks_ = remarks_on_deviations(car, *prior_, vehicle_);
  if (!refusal_.empty()) return unknown(Unknown::kIllConditioned);
  remarks_.insert(remarks_.begin(), remark_on_scale(*car));
  UnknownVector widened = UnknownVector::Ones();
  if (drives.size() > 1)
    if (const auto covariance = estimate_covariance(drive, priors_, drives)) {
      drives_ratio_ = covariance->drives_ratio;
      widened = covariance->drives_widening;
    }
  publish(*car, widened);
  forces_ = drive_forces(drive.totals(), car->unknowns(), priors_);
}

void EstimateReport::draw_body(const SpeedClasses& drive, const PhaseDrift& drift,
                               const DriveGroups& drives) {
  const DriveMoments total = drive.total();
  const auto x = solve(total, priors_.geometry, priors_.value);
  const auto covariance = x ? estimate_covariance(drive, priors_, drives) : std::nullopt;
  if (!covariance) return unknown(Unknown::kIllConditioned);
  publish_body(*x, *covariance, drift);
  drives_ratio_ = covariance->drives_ratio;
  estimate_.identification.state = Unknown::kUnfitVehicle;
  add_variance_of_parameters(total);
}

void EstimateReport::describe(const SpeedClasses& drive, const PhaseDrift& drift, std::int64_t time_ns) {
  Identification& result = estimate_.identification;
  result.time_ns = time_ns;
  result.seconds_used = 0.0;
  result.sections = 0;
  result.speed_class.clear();
  const std::vector<DriveMoments> classes = drive.totals();
  for (const DriveMoments& total : classes) {
    result.seconds_used += total.seconds;
    result.sections += total.sections;
    if (result.speed_class.size() < kMaxSpeedClasses)
      result.speed_class.push_back({total.speed_seconds / total.seconds, total.seconds});
  }
  result.seconds_needed = kLeastSections * result.seconds_used / result.sections;
  for (int w = 0; w < kWheels; ++w) {
    Balance& balance = estimate_.balance[static_cast<std::size_t>(w)];
    balance.time_ns = time_ns;
    balance.seconds_used = result.seconds_used;
    balance.least_speed_m_s = classes.front().speed_seconds / classes.front().seconds;
    balance.greatest_speed_m_s = classes.back().speed_seconds / classes.back().seconds;
    balance.phase_drift_rad = std::numeric_limits<double>::quiet_NaN();
    for (int other = 0; other < kWheels; ++other)
      if (const auto turned = drift.drift_rad(w, other); turned && other != w)
        balance.phase_drift_rad = std::fmin(balance.phase_drift_rad, *turned);
  }
}

void EstimateReport::unknown(Unknown state) {
  forces_.speed.clear();
  estimate_.identification.state = state;
  for (std::size_t i = 0; i < kWheels; ++i) {
    estimate_.balance[i].weight_radius_m = vehicle_.wheel[i].weight_radius_m;
    estimate_.balance[i].state = vehicle_.wheel[i].node.empty() ? Unknown::kNoReference : state;
  }
}

void EstimateReport::publish(const PosteriorCar& car, const UnknownVector& widened) {
  unknown(Unknown::kNone);
  UnknownVector sigma = widened.cwiseSqrt();
  sigma.head<kEstimatedUnbalance>().array() *= car.sigma.segment<kEstimatedUnbalance>(kSpring).array();
  put_suspension(car.unknowns(), sigma, estimate_.identification);
  for (std::size_t w = 0; w < kWheels; ++w) {
    Balance& balance = estimate_.balance[w];
    const WheelFirstOrder& wheel = car.wheel[w];
    if (balance.state == Unknown::kNone && !std::isfinite(std::abs(wheel.correction_kg_m)))
      balance.state = Unknown::kNoReference;
    if (balance.state != Unknown::kNone) continue;
    const double factor = widened(kEstimatedUnbalance + 2 * static_cast<Eigen::Index>(w));
    const Eigen::Vector2d correction(wheel.correction_kg_m.real(), wheel.correction_kg_m.imag());
    put_unbalance(correction, factor * wheel.heard_covariance, balance);
    balance.sigma_drive_g = balance.sigma_g;
    put_unbalance(correction, factor * wheel.correction_covariance, balance);
    put_first_order(wheel, factor, balance);
    add_variance_of_datum(balance);
  }
}

void EstimateReport::publish_body(const UnknownVector& x, const EstimateCovariance& covariance,
                                  const PhaseDrift& drift) {
  unknown(Unknown::kNone);
  const std::array<std::optional<int>, kWheels> with = in_step(drift);
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    Balance& balance = estimate_.balance[w];
    const int u = kEstimatedUnbalance + 2 * i;
    const auto unbalance = x.segment<2>(u);
    if (with[w])
      balance.state = Unknown::kInStep;
    else if (!unbalance.allFinite())
      balance.state = Unknown::kNoReference;
    if (balance.state != Unknown::kNone) continue;
    put_unbalance(unbalance, covariance.drive.block<2, 2>(u, u), balance);
    balance.sigma_drive_g = balance.sigma_g;
    // No scatter of a drive shows how true its sensors are.
    const double gain = gain_variance(vehicle_, w);
    add_variance(balance, gain, gain);
    add_variance_of_datum(balance);
  }
}

/// No drive shows where a wheel's zero mark is thought to be.
void EstimateReport::add_variance_of_datum(Balance& balance) const {
  const double sigma_rad = vehicle_.wheel[static_cast<std::size_t>(balance.wheel)].encoder.datum_sigma_rad;
  add_variance(balance, 0.0, sigma_rad * sigma_rad);
}

void EstimateReport::add_variance_of_parameters(const DriveMoments& drive) {
  const auto variance = response_variance(vehicle_, drive.speed_seconds / drive.seconds);
  for (std::size_t w = 0; w < kWheels; ++w)
    if (estimate_.balance[w].state == Unknown::kNone)
      add_variance(estimate_.balance[w], variance[w].along, variance[w].across);
}

}  // namespace roadbalance
