#include "host/identify/drive_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/config/section.hpp"
#include "host/identify/body_instrument.hpp"
#include "host/identify/doubt.hpp"
#include "host/identify/missing_angle.hpp"
#include "host/identify/phase_drift.hpp"
#include "host/identify/publish_estimate.hpp"
#include "host/identify/refusal.hpp"

namespace roadbalance {
namespace {

/// An hour of driving that does not tell the car is not kept to be weighed anew.
constexpr std::size_t kMostEarly = 400;

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

}  // namespace

DriveEstimator::DriveEstimator(const VehicleConfig& vehicle)
    : vehicle_(vehicle),
      known_(Known::of(vehicle)),
      classes_(vehicle.drive.speed_class_m_s),
      obstacle_(why_no_angle(vehicle)),
      body_only_(shows_body_only(vehicle)),
      sections_(
          vehicle_, [this](const DrivenSection& section) { add_section(section); }, body_only_) {
  if (body_only_)
    obstacle_ +=
        std::string(obstacle_.empty() ? "" : "; ") +
        "no vertical sensor shows the carrier of some wheel: unbalances come from the body alone, with "
        "springs, dampers and tyres as vehicle.toml has them";
  estimate_.identification.least_speed_m_s = vehicle.drive.least_speed_m_s;
  estimate_.identification.seconds_needed = kLeastSections * vehicle.drive.section_s;
  for (int i = 0; i < kWheels; ++i) estimate_.balance[static_cast<std::size_t>(i)].wheel = i;
  const bool angle =
      std::any_of(vehicle.wheel.begin(), vehicle.wheel.end(), [](const auto& w) { return !w.node.empty(); });
  publish_unknown(angle ? Unknown::kTooShort : Unknown::kNoReference);
  try {
    decimator_.emplace(decimation_factor(vehicle_),
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
  const std::string refused = body_only_ ? in_step_sentence(sections_.phase_drift()) : refusal_;
  return obstacle_ + (obstacle_.empty() || refused.empty() ? "" : "; ") + refused;
}

void DriveEstimator::add_sample(const IdentificationSample& sample) {
  time_ns_ = sample.time_ns;
  const std::int64_t before = sections_.news();
  sections_.consume(sample);
  if (sections_.news() != before) note_news();
}

/// The estimate is to be that of this instant, whenever it is asked for.
void DriveEstimator::note_news() {
  ++version_;
  stale_ = true;
  news_ns_ = time_ns_;
}

const DriveEstimate& DriveEstimator::estimate() {
  if (std::exchange(stale_, false)) update_estimate();
  return estimate_;
}

/// Before the first section: why there is none.
void DriveEstimator::report_unknown(Unknown state) {
  if (estimate_.identification.state == state) return;
  publish_unknown(state);
  ++version_;
}

void DriveEstimator::add_section(const DrivenSection& section) {
  classes_.add(section);
  if (!weights_known_ && early_.size() < kMostEarly) early_.push_back(section);
  note_news();
  learn_weights();
}

/// What is known of the car makes the weights of the sections to come.
void DriveEstimator::learn_weights() {
  if (body_only_ || classes_.sections() < kLeastSections) return;
  const auto x = solve(classes_.total(), known_.geometry, known_.value);
  if (!x || implausible(*x, known_)) return;
  ParameterVector parameters = known_.value;
  parameters.segment<kEstimatedUnbalance>(kSpring) = x->head<kEstimatedUnbalance>();
  sections_.set_parameters(parameters);
  if (!std::exchange(weights_known_, true)) weigh_early_sections();
}

/// What was driven before the car was known is weighed as well as what comes.
void DriveEstimator::weigh_early_sections() {
  if (classes_.sections() == std::ssize(early_)) {
    classes_ = SpeedClasses(vehicle_.drive.speed_class_m_s);
    for (DrivenSection& section : early_) {
      sections_.weigh_anew(section);
      classes_.add(section);
    }
  }
  early_.clear();
}

void DriveEstimator::update_estimate() {
  SpeedClasses all = classes_;
  if (const auto running = sections_.running()) all.add(*running);
  if (all.empty()) return;
  describe_drive(all);
  const DriveMoments drive = all.total();
  if (drive.sections < kLeastSections) return publish_unknown(Unknown::kTooShort);
  const auto x = solve(drive, known_.geometry, known_.value);
  const auto judgement = x ? judge(all, known_) : std::nullopt;
  if (!body_only_) refusal_ = refusal(x, judgement, known_);
  estimate_.identification.condition = judgement ? judgement->suspension.condition : 0.0;
  if (!judgement || !refusal_.empty()) return publish_unknown(Unknown::kIllConditioned);
  publish(*x, *judgement);
  if (!body_only_) {
    forces_ = drive_forces(all.totals(), *x, known_);
    return;
  }
  estimate_.identification.state = Unknown::kUnfitVehicle;
  add_doubt_of_parameters(drive);
}

void DriveEstimator::describe_drive(const SpeedClasses& drive) {
  Identification& result = estimate_.identification;
  result.time_ns = news_ns_;
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
    balance.time_ns = news_ns_;
    balance.seconds_used = result.seconds_used;
    balance.least_speed_m_s = classes.front().speed_seconds / classes.front().seconds;
    balance.greatest_speed_m_s = classes.back().speed_seconds / classes.back().seconds;
    balance.phase_drift_rad = std::numeric_limits<double>::quiet_NaN();
    for (int other = 0; other < kWheels; ++other)
      if (const auto drift = sections_.phase_drift().drift_rad(w, other); drift && other != w)
        balance.phase_drift_rad = std::fmin(balance.phase_drift_rad, *drift);
  }
}

void DriveEstimator::publish_unknown(Unknown state) {
  forces_.speed.clear();
  estimate_.identification.state = state;
  for (std::size_t i = 0; i < kWheels; ++i) {
    estimate_.balance[i].weight_radius_m = vehicle_.wheel[i].weight_radius_m;
    estimate_.balance[i].state = vehicle_.wheel[i].node.empty() ? Unknown::kNoReference : state;
  }
}

void DriveEstimator::publish(const UnknownVector& x, const Judgement& judgement) {
  publish_unknown(Unknown::kNone);
  publish_balances(x, judgement);
  if (body_only_) return;
  put_suspension(x, judgement.drive + judgement.model, estimate_.identification);
  put_judgement(judgement, estimate_.identification);
}

void DriveEstimator::publish_balances(const UnknownVector& x, const Judgement& judgement) {
  std::array<std::optional<int>, kWheels> with;
  if (body_only_) with = in_step(sections_.phase_drift());
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
    put_unbalance(unbalance, judgement.drive.block<2, 2>(u, u), balance);
    balance.sigma_drive_g = balance.sigma_g;
    put_unbalance(unbalance, (judgement.drive + judgement.model).block<2, 2>(u, u), balance);
    if (!body_only_) put_first_order(judgement.first_order[w], balance);
    // No scatter of a drive shows where its zero marks are thought to be, nor how true its sensors are.
    const double datum_sigma_rad = vehicle_.wheel[w].encoder.datum_sigma_rad;
    const double gain = gain_variance(vehicle_, w);
    add_doubt(balance, gain, datum_sigma_rad * datum_sigma_rad + gain);
  }
}

void DriveEstimator::add_doubt_of_parameters(const DriveMoments& drive) {
  const auto doubt = response_doubt(vehicle_, drive.speed_seconds / drive.seconds);
  for (std::size_t w = 0; w < kWheels; ++w)
    if (estimate_.balance[w].state == Unknown::kNone)
      add_doubt(estimate_.balance[w], doubt[w].along, doubt[w].across);
}

}  // namespace roadbalance
