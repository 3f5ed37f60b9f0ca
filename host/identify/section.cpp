#include "host/identify/section.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace roadbalance {
namespace {

constexpr double kSettlingS = 3.0;
constexpr int kParts = 10;
constexpr double kSteadiness = 0.02;  ///< a part's speed may differ from the section's by this share

Eigen::Index samples_in(double seconds, double rate_hz) {
  return std::max<Eigen::Index>(1, std::lround(seconds * rate_hz));
}

}  // namespace

SectionBuilder::SectionBuilder(const VehicleConfig& vehicle, Emit emit, bool body_only)
    : rate_hz_(vehicle.drive.identification_rate_hz),
      least_speed_m_s_(vehicle.drive.least_speed_m_s),
      part_(samples_in(vehicle.drive.section_s / kParts, rate_hz_)),
      buffer_(geometry_of(vehicle.model), rate_hz_, kParts * part_, RoadShare::kShared),
      parameters_(nominal_parameters(vehicle)),
      emit_(std::move(emit)) {
  if (body_only) body_.emplace(vehicle, buffer_.taper(), rate_hz_);
  for (std::size_t i = 0; i < kWheels; ++i) {
    rolling_radius_m_[i] = vehicle.wheel[i].rolling_radius_m;
    has_encoder_[i] = !vehicle.wheel[i].node.empty();
  }
}

void SectionBuilder::consume(const IdentificationSample& sample) {
  if (sample.restart) {
    buffer_.reset();
    settling_ = samples_in(kSettlingS, rate_hz_);
  }
  if (settling_ > 0) {
    --settling_;
    return buffer_.settle(sample.signals);
  }
  buffer_.push(sample.signals);
  if (buffer_.filled() % part_ == 0) check_steadiness();
  if (buffer_.full()) finish_section();
}

/// A section whose speed has changed begins again with its newest part, one without a speed from nothing.
void SectionBuilder::check_steadiness() {
  const Eigen::Index filled = buffer_.filled();
  const auto wheel = speed_wheel(0, filled);
  if (!wheel) {
    for (int i = kWheels - 1; i >= 0; --i)
      if (has_encoder_[static_cast<std::size_t>(i)]) missing_reference_ = i;
    return buffer_.keep(speed_wheel(filled - part_, part_) ? part_ : 0);
  }
  const double newest = mean_rotation(*wheel, filled - part_, part_);
  const double before = filled == part_ ? newest : mean_rotation(*wheel, 0, filled - part_);
  if (newest * rolling_radius_m_[static_cast<std::size_t>(*wheel)] < least_speed_m_s_) {
    slow_s_ += static_cast<double>(part_) / rate_hz_;
    buffer_.keep(0);
  } else if (std::abs(newest - before) > kSteadiness * before) {
    buffer_.keep(part_);
  }
}

/// A wheel that turns without its angle would leave its unbalance in the equations of all: such a section is
/// not used.
void SectionBuilder::finish_section() {
  bool complete = true;
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (has_encoder_[static_cast<std::size_t>(wheel)] && !has_reference(wheel, 0, buffer_.filled())) {
      missing_reference_ = wheel;
      complete = false;
    }
  slow_s_ = 0.0;
  if (complete) {
    std::array<bool, kWheels> has_angle{};
    for (int wheel = 0; wheel < kWheels; ++wheel)
      has_angle[static_cast<std::size_t>(wheel)] = has_reference(wheel, 0, buffer_.filled());
    phase_drift_.add(buffer_.signals(), has_angle);
    emit_(moments());
  }
  buffer_.keep(buffer_.shared());
}

/// Mean rotation rate of a wheel over `count` samples from `first`, rad/s, from its reference's phase.
double SectionBuilder::mean_rotation(int wheel, Eigen::Index first, Eigen::Index count) const {
  double turned = 0.0;
  for (Eigen::Index k = first + 1; k < first + count; ++k)
    turned += std::arg(reference(buffer_.signals().col(k), wheel) *
                       std::conj(reference(buffer_.signals().col(k - 1), wheel)));
  return turned * rate_hz_ / static_cast<double>(count - 1);
}

/// True if the wheel's angle was known all through.
bool SectionBuilder::has_reference(int wheel, Eigen::Index first, Eigen::Index count) const {
  const auto power = buffer_.signals().row(cosine_row(wheel)).array().square() +
                     buffer_.signals().row(sine_row(wheel)).array().square();
  return power.segment(first, count).minCoeff() > 0.25;
}

/// A wheel whose angle tells the speed all through.
std::optional<int> SectionBuilder::speed_wheel(Eigen::Index first, Eigen::Index count) const {
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (has_reference(wheel, first, count)) return wheel;
  return std::nullopt;
}

DriveMoments SectionBuilder::moments() const {
  const Eigen::Index samples = buffer_.section().cols();
  const int timer = *speed_wheel(0, samples);  // check_steadiness saw to it that there is one
  const double speed_m_s =
      mean_rotation(timer, 0, samples) * rolling_radius_m_[static_cast<std::size_t>(timer)];
  Eigen::Vector4d omega = Eigen::Vector4d::Zero();
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (has_reference(wheel, 0, buffer_.filled())) omega(wheel) = mean_rotation(wheel, 0, samples);
  if (!body_) return buffer_.moments(omega, speed_m_s, parameters_);
  DriveMoments sum;
  sum.sections = 1;
  sum.seconds = buffer_.seconds();
  sum.speed_seconds = sum.seconds * speed_m_s;
  sum.body = body_->moments(buffer_.section(), omega);
  return sum;
}

}  // namespace roadbalance
