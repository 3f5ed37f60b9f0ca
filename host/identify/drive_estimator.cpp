#include "host/identify/drive_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/config/section.hpp"
#include "host/identify/body_instrument.hpp"
#include "host/identify/confidence.hpp"
#include "host/identify/doubt.hpp"
#include "host/identify/missing_angle.hpp"
#include "host/identify/phase_drift.hpp"

namespace roadbalance {
namespace {

/// Grid samples per identification sample.
int decimation(const VehicleConfig& vehicle) {
  const double factor = vehicle.node.front().rate_hz / vehicle.drive.identification_rate_hz;
  if (factor < 1.0)
    throw ConfigError("vehicle " + vehicle.name + ": identification_rate_hz is above the nodes' rate_hz");
  return static_cast<int>(std::lround(factor));
}

/// An estimate of a stiffness further from vehicle.toml than this factor means that the drive did not tell
/// it.
constexpr double kPlausible = 2.0;

/// True if the sensors show the body's motion but not every wheel's.
bool shows_body_only(const VehicleConfig& vehicle) {
  try {
    SensorMap::from(vehicle);
    return false;
  } catch (const ConfigError&) {
  }
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

double sigma(const UnknownMatrix& covariance, int i) {
  return std::sqrt(covariance(i, i));
}

}  // namespace

DriveEstimator::DriveEstimator(const VehicleConfig& vehicle)
    : vehicle_(vehicle),
      geometry_(geometry_of(vehicle.model)),
      known_(nominal_parameters(vehicle)),
      obstacle_(why_no_angle(vehicle)),
      body_only_(shows_body_only(vehicle)),
      sections_(
          vehicle_, [this](const DriveMoments& section) { add_section(section); }, body_only_) {
  if (body_only_)
    obstacle_ +=
        std::string(obstacle_.empty() ? "" : "; ") +
        "no vertical sensor shows the carrier of some wheel: unbalances come from the body alone, with "
        "springs, dampers and tyres as vehicle.toml has them";
  for (int i = 0; i < kWheels; ++i) estimate_.balance[static_cast<std::size_t>(i)].wheel = i;
  const bool angle =
      std::any_of(vehicle.wheel.begin(), vehicle.wheel.end(), [](const auto& w) { return !w.node.empty(); });
  publish_unknown(angle ? Unknown::kTooShort : Unknown::kNoReference);
  try {
    decimator_.emplace(decimation(vehicle_),
                       [this](const IdentificationSample& sample) { add_sample(sample); });
    assembler_.emplace(vehicle_, body_only_ ? SensorMap::of_body(vehicle_) : SensorMap::from(vehicle_),
                       [this](const SignalRun& run) { decimator_->consume(run); });
  } catch (const ConfigError& error) {
    // Levels and spectra of such a vehicle are as good as any: only this estimate is not to be had.
    obstacle_ = error.what() + (obstacle_.empty() ? "" : "; " + obstacle_);
    publish_unknown(Unknown::kUnfitVehicle);
  }
}

void DriveEstimator::consume(const ClockFit& fit) {
  if (assembler_) assembler_->consume(fit);
}

void DriveEstimator::consume(const SealedBlock& block) {
  if (assembler_) assembler_->consume(block);
  if (!classes_.empty()) return;
  if (assembler_ && !assembler_->no_common_time().empty())
    report_unknown(Unknown::kNoCommonTime);
  else if (sections_.missing_reference())
    report_unknown(Unknown::kNoReference);
  else if (sections_.slow_seconds() > vehicle_.drive.section_s)
    report_unknown(Unknown::kTooSlow);
}

std::string DriveEstimator::obstacle() const {
  if (assembler_ && !assembler_->no_common_time().empty()) return assembler_->no_common_time();
  if (const auto wheel = sections_.missing_reference(); wheel && classes_.empty())
    return obstacle_ + (obstacle_.empty() ? "" : "; ") + kWheelNames[static_cast<std::size_t>(*wheel)] +
           ": its encoder gave no angle; sections without it are not used";
  const std::string refused = body_only_ ? in_step_sentence(sections_.phase_drift()) : "";
  return obstacle_ + (obstacle_.empty() || refused.empty() ? "" : "; ") + refused;
}

void DriveEstimator::add_sample(const IdentificationSample& sample) {
  time_ns_ = sample.time_ns;
  sections_.consume(sample);
}

/// Before the first section: why there is none.
void DriveEstimator::report_unknown(Unknown state) {
  if (estimate_.identification.state == state) return;
  publish_unknown(state);
  ++version_;
}

void DriveEstimator::add_section(const DriveMoments& section) {
  const double speed = section.speed_seconds / section.seconds;
  SpeedClass& speed_class = classes_[static_cast<int>(speed / vehicle_.drive.speed_class_m_s)];
  speed_class.group[static_cast<std::size_t>(speed_class.total.sections) % SpeedClass::kGroups] += section;
  speed_class.total += section;
  update_estimate();
}

void DriveEstimator::update_estimate() {
  ++version_;
  describe_drive();
  std::vector<DriveMoments> groups;
  DriveMoments drive;
  for (const auto& [key, speed_class] : classes_) {
    drive += speed_class.total;
    for (const auto& group : speed_class.group)
      if (group.sections > 0) groups.push_back(group);
  }
  if (drive.sections < kLeastSections) return publish_unknown(Unknown::kTooShort);
  const auto x = solve(drive, geometry_, known_);
  const auto covariance = x ? jackknife_covariance(groups, geometry_, known_) : std::nullopt;
  if (!covariance) return publish_unknown(Unknown::kIllConditioned);
  if (body_only_) return publish(*x, *covariance);
  for (int p = 0; p < kEstimatedUnbalance; ++p) {
    const double ratio = (*x)(p) / known_(kSpring + p);
    const bool stabiliser = p >= kEstimatedStabiliser && p < kEstimatedTyre;  // may truly be weak
    if (!stabiliser && !(ratio > 1.0 / kPlausible && ratio < kPlausible))
      return publish_unknown(Unknown::kIllConditioned);
  }
  publish(*x, *covariance);
  ParameterVector parameters = known_;
  parameters.segment<kEstimatedUnbalance>(kSpring) = x->head<kEstimatedUnbalance>();
  sections_.set_parameters(parameters);
}

void DriveEstimator::describe_drive() {
  Identification& result = estimate_.identification;
  result.time_ns = time_ns_;
  result.seconds_used = 0.0;
  result.sections = 0;
  result.speed_class.clear();
  for (const auto& [key, speed_class] : classes_) {
    result.seconds_used += speed_class.total.seconds;
    result.sections += speed_class.total.sections;
    if (result.speed_class.size() < kMaxSpeedClasses)
      result.speed_class.push_back(
          {speed_class.total.speed_seconds / speed_class.total.seconds, speed_class.total.seconds});
  }
  for (auto& balance : estimate_.balance) {
    balance.time_ns = time_ns_;
    balance.seconds_used = result.seconds_used;
  }
}

void DriveEstimator::publish_unknown(Unknown state) {
  estimate_.identification.state = state;
  for (std::size_t i = 0; i < kWheels; ++i) {
    estimate_.balance[i].weight_radius_m = vehicle_.wheel[i].weight_radius_m;
    estimate_.balance[i].state = vehicle_.wheel[i].node.empty() ? Unknown::kNoReference : state;
  }
}

void DriveEstimator::publish(const UnknownVector& x, const UnknownMatrix& covariance) {
  publish_unknown(Unknown::kNone);
  if (!body_only_) publish_suspension(x, covariance);
  publish_balances(x, covariance);
  add_doubt_of_datums();
  if (!body_only_) return;
  estimate_.identification.state = Unknown::kUnfitVehicle;
  add_doubt_of_parameters();
}

void DriveEstimator::publish_suspension(const UnknownVector& x, const UnknownMatrix& covariance) {
  Identification& result = estimate_.identification;
  for (int i = 0; i < kWheels; ++i) {
    const auto w = static_cast<std::size_t>(i);
    result.spring_n_m[w] = x(kEstimatedSpring + i);
    result.sigma_spring_n_m[w] = sigma(covariance, kEstimatedSpring + i);
    result.damper_n_s_m[w] = x(kEstimatedDamper + i);
    result.sigma_damper_n_s_m[w] = sigma(covariance, kEstimatedDamper + i);
    result.tyre_n_m[w] = x(kEstimatedTyre + i);
    result.sigma_tyre_n_m[w] = sigma(covariance, kEstimatedTyre + i);
  }
  for (int a = 0; a < kAxles; ++a) {
    result.stabiliser_n_m[static_cast<std::size_t>(a)] = x(kEstimatedStabiliser + a);
    result.sigma_stabiliser_n_m[static_cast<std::size_t>(a)] = sigma(covariance, kEstimatedStabiliser + a);
  }
}

void DriveEstimator::publish_balances(const UnknownVector& x, const UnknownMatrix& covariance) {
  std::array<std::optional<int>, kWheels> with;
  if (body_only_) with = in_step(sections_.phase_drift());
  for (int i = 0; i < kWheels; ++i) {
    Balance& balance = estimate_.balance[static_cast<std::size_t>(i)];
    if (with[static_cast<std::size_t>(i)]) {
      balance.state = Unknown::kInStep;
      continue;
    }
    const int u = kEstimatedUnbalance + 2 * i;
    const double grams = 1000.0 / balance.weight_radius_m;  // per kg m
    const Eigen::Vector2d vector = grams * x.segment<2>(u);
    if (!vector.allFinite()) {
      balance.state = Unknown::kNoReference;
      continue;
    }
    balance.covariance_g2 = grams * grams * covariance.block<2, 2>(u, u);
    balance.unbalance_g = vector.norm();
    const Eigen::Vector2d radial = vector.normalized();
    const Eigen::Vector2d tangential(-radial.y(), radial.x());
    balance.sigma_g = std::sqrt(radial.dot(balance.covariance_g2 * radial));
    balance.sigma_rad = std::sqrt(tangential.dot(balance.covariance_g2 * tangential)) / balance.unbalance_g;
    constexpr double kTurn = 2.0 * std::numbers::pi;
    const double angle = std::atan2(vector.y(), vector.x());
    balance.angle_rad = angle < 0.0 ? angle + kTurn : angle;
    balance.weight_angle_rad = std::fmod(balance.angle_rad + std::numbers::pi, kTurn);
  }
}

/// No scatter of a drive shows where its zero marks are thought to be.
void DriveEstimator::add_doubt_of_datums() {
  for (std::size_t w = 0; w < kWheels; ++w) {
    const double sigma_rad = vehicle_.wheel[w].encoder.datum_sigma_rad;
    if (estimate_.balance[w].state == Unknown::kNone)
      add_doubt(estimate_.balance[w], 0.0, sigma_rad * sigma_rad);
  }
}

void DriveEstimator::add_doubt_of_parameters() {
  double seconds = 0.0, metres = 0.0;
  for (const auto& [key, speed_class] : classes_) {
    seconds += speed_class.total.seconds;
    metres += speed_class.total.speed_seconds;
  }
  const auto doubt = response_doubt(vehicle_, metres / seconds);
  for (std::size_t w = 0; w < kWheels; ++w) {
    Balance& balance = estimate_.balance[w];
    if (balance.state != Unknown::kNone) continue;
    add_doubt(balance, doubt[w].along, doubt[w].across);
  }
}

}  // namespace roadbalance
