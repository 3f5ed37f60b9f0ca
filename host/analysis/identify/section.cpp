#include "host/analysis/identify/section.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/analysis/identify/rotation.hpp"

namespace roadbalance {
namespace {

constexpr double kSettlingS = 3.0;
constexpr int kParts = 10;
constexpr Eigen::Index kLeastParts = 5;
constexpr double kRoadBins = 300.0;       ///< beside the lines, that weights remember: about 80 s of driving
constexpr double kLeastQuiet = 0.3;       ///< of a section's samples, so that its lines are read
constexpr double kPartSteadiness = 0.02;  ///< a part's speed may differ from the section's by this share

}  // namespace

SectionBuilder::SectionBuilder(const VehicleConfig& vehicle, Emit emit, const Eigen::MatrixXd& sensors)
    : rate_hz_(vehicle.drive.identification_rate_hz),
      least_speed_m_s_(vehicle.drive.least_speed_m_s),
      part_(samples_in(vehicle.drive.section_s / kParts, rate_hz_)),
      buffer_(geometry_of(vehicle.model), rate_hz_, kParts * part_),
      vehicle_(vehicle),
      geometry_(geometry_of(vehicle.model)),
      parameters_(nominal_parameters(vehicle)),
      emit_(std::move(emit)) {
  for (std::size_t i = 0; i < kWheels; ++i) {
    rolling_radius_m_[i] = vehicle.wheel[i].rolling_radius_m;
    has_encoder_[i] = !vehicle.wheel[i].node.empty();
  }
  if (sensors.rows() > 0)
    motion_.emplace(geometry_, sensors, rate_hz_, kParts * part_ + SectionBuffer::lag(rate_hz_));
}

void SectionBuilder::consume(const IdentificationSample& sample) {
  if (sample.restart) {
    if (!sample.spoiled) take(whole_parts(buffer_.filled()));
    begin_anew(0);
    buffer_.reset();
    if (motion_) motion_->reset();
    settling_ = samples_in(kSettlingS, rate_hz_);
  }
  if (settling_ > 0) {
    --settling_;
    if (motion_) motion_->settle(sample.readings);
    return buffer_.settle(sample.signals);
  }
  buffer_.push(sample.signals);
  if (motion_) motion_->push(sample.readings, sample.signals);
  if (buffer_.filled() % part_ == 0) check_steadiness();
  if (whole_parts(buffer_.filled()) > 0 && (buffer_.filled() - SectionBuffer::lag(rate_hz_)) % part_ == 0)
    ++news_;
  if (buffer_.full()) finish_section();
}

/// Samples in the whole parts of the first `samples`, with their lag behind them.
Eigen::Index SectionBuilder::whole_parts(Eigen::Index samples) const {
  const Eigen::Index parts = (samples - SectionBuffer::lag(rate_hz_)) / part_;
  return parts < kLeastParts ? 0 : parts * part_;
}

/// With the newest samples only; what running() would have shown is gone.
void SectionBuilder::begin_anew(Eigen::Index count) {
  if (whole_parts(buffer_.filled()) > 0) ++news_;
  buffer_.keep(count);
  if (motion_) motion_->keep(count);
}

/// A section whose speed has changed begins again with its newest part, one without a speed from nothing.
void SectionBuilder::check_steadiness() {
  const Eigen::Index filled = buffer_.filled();
  const auto wheel = speed_wheel(0, filled);
  if (!wheel) {
    for (int i = kWheels - 1; i >= 0; --i)
      if (has_encoder_[static_cast<std::size_t>(i)]) missing_reference_ = i;
    return begin_anew(speed_wheel(filled - part_, part_) ? part_ : 0);
  }
  const double newest = mean_rotation(*wheel, filled - part_, part_);
  const double before = filled == part_ ? newest : mean_rotation(*wheel, 0, filled - part_);
  if (newest * rolling_radius_m_[static_cast<std::size_t>(*wheel)] < least_speed_m_s_) {
    slow_s_ += static_cast<double>(part_) / rate_hz_;
    begin_anew(0);
  } else if (std::abs(newest - before) > kPartSteadiness * before) {
    take(whole_parts(filled - part_ + SectionBuffer::lag(rate_hz_)));
    begin_anew(part_);
  }
}

void SectionBuilder::finish_section() {
  slow_s_ = 0.0;
  const Eigen::Index shared = buffer_.shared();
  if (!take(buffer_.section().cols())) return begin_anew(shared);
  ++news_;
  buffer_.keep(shared);
  if (motion_) motion_->go_on(shared);
}

/// Takes the first `samples` for a section.  A wheel that turns without its angle would leave its unbalance
/// in the equations of all: such a section is not used.
bool SectionBuilder::take(Eigen::Index samples) {
  if (samples == 0) return false;
  if (const auto wheel = wheel_without_angle(samples)) {
    missing_reference_ = wheel;
    return false;
  }
  std::array<bool, kWheels> has_angle{};
  for (int wheel = 0; wheel < kWheels; ++wheel)
    has_angle[static_cast<std::size_t>(wheel)] = has_reference(wheel, 0, samples);
  phase_drift_.add(buffer_.signals().leftCols(samples), has_angle);
  const DrivenSection taken = section(samples, Part::kAll);
  road_ = newest_road_;
  emit_(taken);
  return true;
}

std::optional<DrivenSection> SectionBuilder::running() {
  return running(Part::kMoments);
}

std::optional<DrivenSection> SectionBuilder::running_lines() {
  return running(Part::kLines);
}

std::optional<DrivenSection> SectionBuilder::running(Part part) {
  const Eigen::Index samples = whole_parts(buffer_.filled());
  if (samples == 0 || wheel_without_angle(samples)) return std::nullopt;
  return section(samples, part);
}

/// With an encoder, but without an angle somewhere in the first `samples` or their lag.
std::optional<int> SectionBuilder::wheel_without_angle(Eigen::Index samples) const {
  for (int wheel = kWheels - 1; wheel >= 0; --wheel)
    if (has_encoder_[static_cast<std::size_t>(wheel)] &&
        !has_reference(wheel, 0, samples + SectionBuffer::lag(rate_hz_)))
      return wheel;
  return std::nullopt;
}

/// Mean rotation rate over `count` samples from `first`, rad/s, of a wheel that has its angle there.
double SectionBuilder::mean_rotation(int wheel, Eigen::Index first, Eigen::Index count) const {
  return *roadbalance::mean_rotation(buffer_.signals().middleCols(first, count), wheel, rate_hz_);
}

/// True if the wheel's angle was known all through.
bool SectionBuilder::has_reference(int wheel, Eigen::Index first, Eigen::Index count) const {
  return roadbalance::has_reference(buffer_.signals().middleCols(first, count), wheel);
}

/// A wheel whose angle gives the speed all through.
std::optional<int> SectionBuilder::speed_wheel(Eigen::Index first, Eigen::Index count) const {
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (has_reference(wheel, first, count)) return wheel;
  return std::nullopt;
}

void SectionBuilder::weigh_anew(DrivenSection& section) const {
  weigh(section, road_);
}

/// @param density  of the road
void SectionBuilder::weigh(DrivenSection& section, const RoadSpectrum& density) const {
  const HarmonicReading& reading = section.reading;
  if (reading.lines.wheels.empty()) return;
  section.harmonic =
      harmonic_moments(reading.lines, geometry_, parameters_, reading.road_of(density), RoadShare::kShared);
  section.lines = line_moments(reading, motion_->channels(), density, geometry_, parameters_);
}

DrivenSection SectionBuilder::section(Eigen::Index samples, Part part) {
  const int timer = *speed_wheel(0, samples);  // check_steadiness saw to it that there is one
  const double radius_m = rolling_radius_m_[static_cast<std::size_t>(timer)];
  const double speed_m_s = mean_rotation(timer, 0, samples) * radius_m;
  Eigen::Vector4d omega = Eigen::Vector4d::Zero();
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (has_reference(wheel, 0, samples + SectionBuffer::lag(rate_hz_)))
      omega(wheel) = mean_rotation(wheel, 0, samples);
  if (!motion_) return section_of_body(samples, omega, speed_m_s);
  const Eigen::Index behind = buffer_.filled() - samples;
  const Eigen::ArrayXd quiet = motion_->quiet(behind);
  DrivenSection section;
  if (part != Part::kLines)
    static_cast<DriveMoments&>(section) = buffer_.moments(samples, omega, speed_m_s);
  else
    section.count(buffer_.seconds(samples), speed_m_s);
  if (quiet.tail(samples).mean() >= kLeastQuiet)
    section.reading =
        buffer_.harmonic(samples, omega, speed_m_s, motion_->readings(samples, behind), quiet.tail(samples));
  section.cut_s = static_cast<double>(samples) / rate_hz_ - section.reading.seconds;
  newest_road_ = road_.remembering(kRoadBins);
  newest_road_ += section.reading.density();
  weigh(section, newest_road_);
  if (part == Part::kAll) section.spectra = motion_->take(quiet, omega, timer, radius_m);
  return section;
}

DrivenSection SectionBuilder::section_of_body(Eigen::Index samples, const Eigen::Vector4d& omega,
                                              double speed_m_s) {
  auto body = body_.find(samples);
  if (body == body_.end())
    body = body_.emplace(samples, BodyInstrument(vehicle_, buffer_.taper(samples), rate_hz_)).first;
  DrivenSection sum;
  sum.count(buffer_.seconds(samples), speed_m_s);
  sum.body = body->second.moments(buffer_.signals().leftCols(samples), omega);
  return sum;
}

}  // namespace roadbalance
