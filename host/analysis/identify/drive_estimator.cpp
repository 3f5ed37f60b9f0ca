#include "host/analysis/identify/drive_estimator.hpp"

#include <utility>

#include "common/config/section.hpp"
#include "common/vehicle/sensor_map.hpp"

namespace roadbalance {
namespace {

/// An hour of driving that does not determine the car is not kept to be weighed anew.
constexpr std::size_t kMostEarly = 400;

/// Near enough to vehicle.toml to weigh sections by; stabilisers may truly be weak.
bool plausible(const UnknownVector& x, const Priors& priors) {
  constexpr double kFactor = 2.0;
  for (int p = 0; p < kEstimatedUnbalance; ++p) {
    const double ratio = x(p) / priors.value(kSpring + p);
    const bool stabiliser = p >= kEstimatedStabiliser && p < kEstimatedTyre;
    if (!stabiliser && !(ratio > 1.0 / kFactor && ratio < kFactor)) return false;
  }
  return true;
}

}  // namespace

DriveEstimator::DriveEstimator(const VehicleConfig& vehicle)
    : vehicle_(vehicle),
      report_(vehicle),
      classes_(vehicle.drive.speed_class_m_s),
      sections_(
          vehicle_, [this](const DrivenSection& section) { add_section(section); },
          report_.prior() ? report_.prior()->sensors : Eigen::MatrixXd()) {
  if (report_.prior()) posterior_.emplace(*report_.prior(), vehicle.drive.speed_class_m_s);
  try {
    decimator_.emplace(decimation_factor(vehicle_),
                       [this](const IdentificationSample& sample) { add_sample(sample); });
    assembler_.emplace(vehicle_,
                       report_.body_only() ? SensorMap::of_body(vehicle_) : SensorMap::from(vehicle_),
                       [this](const SignalRun& run) { decimator_->consume(run); });
  } catch (const ConfigError& error) {
    // Levels and spectra of such a vehicle are as good as any: only this estimate is not to be had.
    report_.unfit(error.what());
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

std::string DriveEstimator::refusal() const {
  if (assembler_ && !assembler_->no_common_time().empty()) return assembler_->no_common_time();
  if (!classes_.empty()) return report_.refusal(sections_.phase_drift());
  std::string all;
  const auto add = [&all](const std::string& sentence) {
    if (!sentence.empty()) all += (all.empty() ? "" : "; ") + sentence;
  };
  for (const std::string& sentence : clipped()) add(sentence);
  if (const auto wheel = sections_.missing_reference()) {
    add(report_.of_vehicle());
    add(std::string(kWheelNames[static_cast<std::size_t>(*wheel)]) +
        ": its encoder gave no angle; sections without it are not used");
  } else {
    add(report_.refusal(sections_.phase_drift()));
  }
  return all;
}

std::vector<std::string> DriveEstimator::clipped() const {
  return assembler_ ? assembler_->clipped() : std::vector<std::string>();
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
  if (std::exchange(stale_, false)) {
    const auto running = sections_.running_lines();
    car_ = posterior_ ? posterior_->solve(running) : std::nullopt;
    report_.draw(classes_so_far(running), car_, sections_.phase_drift(), news_ns_);
  }
  return report_.estimate();
}

/// Before the first section: why there is none.
void DriveEstimator::report_unknown(Unknown state) {
  if (report_.estimate().identification.state == state) return;
  report_.unknown(state);
  ++version_;
}

void DriveEstimator::add_section(const DrivenSection& section) {
  classes_.add(section);
  if (posterior_) posterior_->add(section);
  if (!weights_known_ && early_.size() < kMostEarly) {
    early_.push_back(section);
    early_.back().spectra = {};
  }
  note_news();
  learn_weights();
}

/// The estimated car gives the weights of the sections to come.
void DriveEstimator::learn_weights() {
  const Priors& priors = report_.priors();
  if (report_.body_only() || classes_.sections() < kLeastSections) return;
  const auto x = solve(classes_.total(), priors.geometry, priors.value);
  if (!x || !plausible(*x, priors)) return;
  ParameterVector parameters = priors.value;
  parameters.segment<kEstimatedUnbalance>(kSpring) = x->head<kEstimatedUnbalance>();
  sections_.set_parameters(parameters);
  if (!std::exchange(weights_known_, true)) weigh_early_sections();
}

/// Sections driven before the car was known are weighed as well as those to come.
void DriveEstimator::weigh_early_sections() {
  if (classes_.sections() == std::ssize(early_)) {
    classes_ = SpeedClasses(vehicle_.drive.speed_class_m_s);
    for (DrivenSection& section : early_) {
      sections_.weigh_anew(section);
      classes_.add(section);
    }
    if (posterior_) posterior_->replace_lines(early_);
  }
  early_.clear();
}

/// With the section that is still being driven.
SpeedClasses DriveEstimator::classes_so_far(const std::optional<DrivenSection>& running) const {
  SpeedClasses all = classes_;
  if (running) all.add(*running);
  return all;
}

DriveSums DriveEstimator::sums() {
  DriveSums sums(vehicle_.drive.speed_class_m_s);
  const auto running = sections_.running();
  sums.classes = classes_so_far(running);
  if (posterior_) {
    sums.posterior = posterior_->sums();
    if (running) sums.posterior.add(*running, vehicle_.drive.speed_class_m_s);
  }
  sums.drift = sections_.phase_drift();
  sums.time_ns = time_ns_;
  sums.state = sums.classes.empty() ? report_.estimate().identification.state : Unknown::kNone;
  if (sums.classes.empty()) sums.refusal = refusal();
  return sums;
}

}  // namespace roadbalance
