#include "host/identify/section.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace roadbalance {
namespace {

constexpr double kChassisCutoffHz = 15.0;
constexpr int kFilterOrder = 5;
constexpr double kChassisLagS = 0.020;
constexpr double kTyreLowHz = 1.0;
constexpr double kTyreHighHz = 80.0;
constexpr double kTyreLagS = 0.004;
constexpr double kSettlingS = 3.0;
constexpr double kTaperFraction = 0.1;
constexpr int kParts = 10;
constexpr double kSteadiness = 0.02;  ///< a part's speed may differ from the section's by this share

/// 1 / ((p + wl/wh)^2 (p^3 + 2 p^2 + 2 p + 1)) with p = s / wh, in companion form scaled by wh.
ContinuousFilter tyre_instrument() {
  const double low = kTyreLowHz / kTyreHighHz;
  const Eigen::Vector3d high_pass(low * low, 2.0 * low, 1.0);
  const Eigen::Vector4d low_pass(1.0, 2.0, 2.0, 1.0);
  Eigen::VectorXd product = Eigen::VectorXd::Zero(kFilterOrder + 1);
  for (int i = 0; i < 3; ++i) product.segment<4>(i) += high_pass(i) * low_pass;
  ContinuousFilter filter = companion(product.head(kFilterOrder));
  filter.F *= 2.0 * std::numbers::pi * kTyreHighHz;
  filter.G *= 2.0 * std::numbers::pi * kTyreHighHz;
  return filter;
}

Eigen::Index samples_in(double seconds, double rate_hz) {
  return std::max<Eigen::Index>(1, std::lround(seconds * rate_hz));
}

/// Three successive states of a scaled companion filter as w, w', w'': y_j / wc^2, y_(j+1) / wc, y_(j+2),
/// under the taper.  Rows instruments, columns samples.
struct Tapered {
  Eigen::MatrixXd w2, w1, w0;
};
Tapered tapered(const Eigen::Ref<const Eigen::MatrixXd>& y0, const Eigen::Ref<const Eigen::MatrixXd>& y1,
                const Eigen::Ref<const Eigen::MatrixXd>& y2, double corner_hz, const Taper& taper) {
  const double corner = 2.0 * std::numbers::pi * corner_hz;
  const Eigen::MatrixXd w0 = y0 / (corner * corner);
  const Eigen::MatrixXd w1 = y1 / corner;
  const auto h = taper.value.matrix().asDiagonal();
  const auto h1 = taper.first.matrix().asDiagonal();
  const auto h2 = taper.second.matrix().asDiagonal();
  return {y2 * h + 2.0 * w1 * h1 + w0 * h2, w1 * h + w0 * h1, w0 * h};
}

}  // namespace

SectionBuilder::SectionBuilder(const VehicleConfig& vehicle, Emit emit, bool body_only)
    : rate_hz_(vehicle.drive.identification_rate_hz),
      least_speed_m_s_(vehicle.drive.least_speed_m_s),
      samples_(kParts * samples_in(vehicle.drive.section_s / kParts, rate_hz_)),
      part_(samples_ / kParts),
      chassis_lag_(samples_in(kChassisLagS, rate_hz_)),
      tyre_lag_(samples_in(kTyreLagS, rate_hz_)),
      chassis_filter_(discretise_ramp_invariant(butterworth(kFilterOrder, kChassisCutoffHz), 1.0 / rate_hz_),
                      kCoordinates),
      tyre_filter_(discretise_ramp_invariant(tyre_instrument(), 1.0 / rate_hz_), kWheels),
      taper_(c2_taper(samples_, kTaperFraction, 1.0 / rate_hz_)),
      harmonic_(vehicle, taper_, rate_hz_),
      parameters_(nominal_parameters(vehicle)),
      emit_(std::move(emit)) {
  if (body_only) body_.emplace(vehicle, taper_, rate_hz_);
  const Eigen::Index columns = samples_ + std::max(chassis_lag_, tyre_lag_);
  signals_.setZero(kSignals, columns);
  chassis_states_.setZero(kFilterOrder * kCoordinates, columns);
  tyre_states_.setZero(kFilterOrder * kWheels, columns);
  for (std::size_t i = 0; i < kWheels; ++i) {
    rolling_radius_m_[i] = vehicle.wheel[i].rolling_radius_m;
    has_encoder_[i] = !vehicle.wheel[i].node.empty();
  }
}

void SectionBuilder::consume(const IdentificationSample& sample) {
  if (sample.restart) {
    chassis_filter_.reset();
    tyre_filter_.reset();
    settling_ = samples_in(kSettlingS, rate_hz_);
    filled_ = 0;
  }
  const auto& chassis = chassis_filter_.update(sample.signals.head<kCoordinates>().array());
  const auto& tyre = tyre_filter_.update(sample.signals.segment<kWheels>(kBodyCoordinates).array());
  if (settling_ > 0) {
    --settling_;
    return;
  }
  signals_.col(filled_) = sample.signals;
  chassis_states_.col(filled_) = chassis.reshaped().matrix();
  tyre_states_.col(filled_) = tyre.reshaped().matrix();
  ++filled_;
  if (filled_ <= samples_ && filled_ % part_ == 0) check_steadiness();
  if (filled_ == signals_.cols()) finish_section();
}

/// Keeps the newest `keep` samples as the beginning of the next section.
void SectionBuilder::restart(Eigen::Index keep) {
  const Eigen::Index from = filled_ - keep;
  signals_.leftCols(keep) = signals_.middleCols(from, keep).eval();
  chassis_states_.leftCols(keep) = chassis_states_.middleCols(from, keep).eval();
  tyre_states_.leftCols(keep) = tyre_states_.middleCols(from, keep).eval();
  filled_ = keep;
}

/// A section whose speed has changed begins again with its newest part, one without a speed from nothing.
void SectionBuilder::check_steadiness() {
  const auto wheel = speed_wheel(0, filled_);
  if (!wheel) {
    for (int i = kWheels - 1; i >= 0; --i)
      if (has_encoder_[static_cast<std::size_t>(i)]) missing_reference_ = i;
    return restart(speed_wheel(filled_ - part_, part_) ? part_ : 0);
  }
  const double newest = mean_rotation(*wheel, filled_ - part_, part_);
  const double before = filled_ == part_ ? newest : mean_rotation(*wheel, 0, filled_ - part_);
  if (newest * rolling_radius_m_[static_cast<std::size_t>(*wheel)] < least_speed_m_s_) {
    slow_s_ += static_cast<double>(part_) / rate_hz_;
    restart(0);
  } else if (std::abs(newest - before) > kSteadiness * before) {
    restart(part_);
  }
}

/// A wheel that turns without its angle would leave its unbalance in the equations of all: such a section is
/// not used.
void SectionBuilder::finish_section() {
  bool complete = true;
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (has_encoder_[static_cast<std::size_t>(wheel)] && !has_reference(wheel, 0, filled_)) {
      missing_reference_ = wheel;
      complete = false;
    }
  slow_s_ = 0.0;
  if (complete) {
    std::array<bool, kWheels> has_angle{};
    for (int wheel = 0; wheel < kWheels; ++wheel)
      has_angle[static_cast<std::size_t>(wheel)] = has_reference(wheel, 0, filled_);
    phase_drift_.add(signals_.leftCols(filled_), has_angle);
    emit_(moments());
  }
  restart(filled_ - samples_);
}

/// Mean rotation rate of a wheel over `count` samples from `first`, rad/s, from its reference's phase.
double SectionBuilder::mean_rotation(int wheel, Eigen::Index first, Eigen::Index count) const {
  double turned = 0.0;
  for (Eigen::Index k = first + 1; k < first + count; ++k)
    turned += std::arg(reference(signals_.col(k), wheel) * std::conj(reference(signals_.col(k - 1), wheel)));
  return turned * rate_hz_ / static_cast<double>(count - 1);
}

/// True if the wheel's angle was known all through.
bool SectionBuilder::has_reference(int wheel, Eigen::Index first, Eigen::Index count) const {
  const auto power =
      signals_.row(cosine_row(wheel)).array().square() + signals_.row(sine_row(wheel)).array().square();
  return power.segment(first, count).minCoeff() > 0.25;
}

/// A wheel whose angle tells the speed all through.
std::optional<int> SectionBuilder::speed_wheel(Eigen::Index first, Eigen::Index count) const {
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (has_reference(wheel, first, count)) return wheel;
  return std::nullopt;
}

DriveMoments SectionBuilder::moments() const {
  DriveMoments sum;
  sum.sections = 1;
  sum.seconds = static_cast<double>(samples_) / rate_hz_;
  const int timer = *speed_wheel(0, samples_);  // check_steadiness saw to it that there is one
  const double speed_m_s =
      mean_rotation(timer, 0, samples_) * rolling_radius_m_[static_cast<std::size_t>(timer)];
  sum.speed_seconds = sum.seconds * speed_m_s;
  Eigen::Vector4d omega = Eigen::Vector4d::Zero();
  for (int wheel = 0; wheel < kWheels; ++wheel)
    if (has_reference(wheel, 0, filled_)) omega(wheel) = mean_rotation(wheel, 0, samples_);
  if (body_) {
    sum.body = body_->moments(signals_.leftCols(samples_), omega);
    return sum;
  }
  add_chassis(sum);
  for (int wheel = 0; wheel < kWheels; ++wheel) add_tyre(sum, wheel, omega(wheel));
  sum.harmonic = harmonic_.moments(signals_.leftCols(samples_), omega, speed_m_s, parameters_);
  return sum;
}

void SectionBuilder::add_chassis(DriveMoments& sum) const {
  const auto z = signals_.block(0, chassis_lag_, kCoordinates, samples_);
  for (int j = 0; j < kChassisInstrumentsPerSignal; ++j) {
    const auto state = [&](int k) {
      return chassis_states_.block((j + k) * kCoordinates, 0, kCoordinates, samples_);
    };
    const Tapered w = tapered(state(0), state(1), state(2), kChassisCutoffHz, taper_);
    const Eigen::MatrixXd w2 = w.w2 * z.transpose();
    const Eigen::MatrixXd w1 = w.w1 * z.transpose();
    const Eigen::MatrixXd w0 = w.w0 * z.transpose();
    for (int s = 0; s < kCoordinates; ++s) {
      const auto i = static_cast<std::size_t>(j * kCoordinates + s);
      sum.chassis[i] = {w2.row(s), w1.row(s), w0.row(s)};
      sum.chassis_power[i] = w.w2.row(s).squaredNorm();
    }
  }
}

void SectionBuilder::add_tyre(DriveMoments& sum, int wheel, double omega) const {
  auto& moments = sum.wheel[static_cast<std::size_t>(wheel)];
  const auto state = [&](int k) { return tyre_states_.block(k * kWheels + wheel, 0, 1, samples_); };
  const Tapered w = tapered(state(0), state(1), state(2), kTyreHighHz, taper_);
  const auto z = signals_.block(0, tyre_lag_, kCoordinates, samples_);
  moments.tyre = {w.w2 * z.transpose(), w.w1 * z.transpose(), w.w0 * z.transpose()};
  const auto later = [&](int row) { return signals_.row(row).segment(tyre_lag_, samples_); };
  moments.tyre_unbalance = omega * omega *
                           std::complex<double>(w.w2.row(0).dot(later(cosine_row(wheel))),
                                                w.w2.row(0).dot(later(sine_row(wheel))));
}

}  // namespace roadbalance
