#include "host/analysis/identify/section_buffer.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>
#include <numbers>

#include "host/analysis/identify/instruments.hpp"

namespace roadbalance {
namespace {

constexpr double kTaperS = 1.0;  ///< rise and fall, the whole section if that is shorter

/// Three successive states of a scaled companion filter as w'', w', w: y_(j+2), y_(j+1) / wc, y_j / wc^2,
/// under the taper.  Rows instruments of w'', then of w', then of w; columns samples.
/// @param kRows  instruments; `first` is the row of y_j's in `states`, those of the next state begin kStep
/// later
template <int kRows, int kStep>
Eigen::Matrix<double, 3 * kRows, Eigen::Dynamic> tapered(const Eigen::MatrixXd& states, Eigen::Index first,
                                                         double corner_hz, const Taper& taper) {
  const double corner = 2.0 * std::numbers::pi * corner_hz;
  Eigen::Matrix<double, 3 * kRows, Eigen::Dynamic> w(3 * kRows, taper.value.size());
  for (Eigen::Index t = 0; t < w.cols(); ++t) {
    const auto state = [&](int k) { return states.col(t).template segment<kRows>(first + k * kStep); };
    const double h = taper.value(t), h1 = taper.first(t), h2 = taper.second(t);
    w.col(t).template segment<kRows>(0) =
        h * state(2) + (2.0 * h1 / corner) * state(1) + (h2 / (corner * corner)) * state(0);
    w.col(t).template segment<kRows>(kRows) = (h / corner) * state(1) + (h1 / (corner * corner)) * state(0);
    w.col(t).template segment<kRows>(2 * kRows) = (h / (corner * corner)) * state(0);
  }
  return w;
}

}  // namespace

Eigen::Index SectionBuffer::lag(double rate_hz) {
  return samples_in(std::max(chassis_instrument().lag_s, tyre_instrument().lag_s), rate_hz);
}

Eigen::Index SectionBuffer::overlap(double rate_hz, Eigen::Index samples) {
  return std::min(samples_in(kTaperS, rate_hz), samples / 2);
}

SectionBuffer::SectionBuffer(const Geometry& geometry, double rate_hz, Eigen::Index samples)
    : rate_hz_(rate_hz),
      chassis_lag_(samples_in(chassis_instrument().lag_s, rate_hz)),
      tyre_lag_(samples_in(tyre_instrument().lag_s, rate_hz)),
      overlap_(overlap(rate_hz, samples)),
      chassis_filter_(discretise_ramp_invariant(chassis_instrument().filter, 1.0 / rate_hz), kCoordinates),
      tyre_filter_(discretise_ramp_invariant(tyre_instrument().filter, 1.0 / rate_hz), kWheels),
      taper_(c2_taper(samples, static_cast<double>(overlap_) / static_cast<double>(samples), 1.0 / rate_hz)),
      geometry_(geometry) {
  const Eigen::Index columns = samples + lag(rate_hz);
  signals_.setZero(kSignals, columns);
  chassis_states_.setZero(kInstrumentOrder * kCoordinates, columns);
  tyre_states_.setZero(kInstrumentOrder * kWheels, columns);
}

void SectionBuffer::reset() {
  chassis_filter_.reset();
  tyre_filter_.reset();
  filled_ = 0;
}

void SectionBuffer::settle(const SignalVector& sample) {
  chassis_filter_.update(sample.head<kCoordinates>().array());
  tyre_filter_.update(sample.segment<kWheels>(kBodyCoordinates).array());
}

void SectionBuffer::push(const SignalVector& sample) {
  assert(!full());
  settle(sample);
  signals_.col(filled_) = sample;
  chassis_states_.col(filled_) = chassis_filter_.states().reshaped().matrix();
  tyre_states_.col(filled_) = tyre_filter_.states().reshaped().matrix();
  ++filled_;
}

void SectionBuffer::keep(Eigen::Index count) {
  const Eigen::Index from = filled_ - count;
  signals_.leftCols(count) = signals_.middleCols(from, count).eval();
  chassis_states_.leftCols(count) = chassis_states_.middleCols(from, count).eval();
  tyre_states_.leftCols(count) = tyre_states_.middleCols(from, count).eval();
  filled_ = count;
}

const SectionBuffer::Window& SectionBuffer::window(Eigen::Index samples) {
  const auto found = windows_.find(samples);
  if (found != windows_.end()) return found->second;
  const double share = static_cast<double>(overlap_) / static_cast<double>(samples);
  const Taper taper = c2_taper(samples, std::min(share, 0.5), 1.0 / rate_hz_);
  return windows_.emplace(samples, Window{taper, HarmonicInstrument(geometry_, taper, rate_hz_)})
      .first->second;
}

HarmonicReading SectionBuffer::harmonic(Eigen::Index samples, const Eigen::Vector4d& omega, double speed_m_s,
                                        const Eigen::Ref<const Eigen::MatrixXd>& readings,
                                        const Eigen::Ref<const Eigen::ArrayXd>& quiet) {
  return window(samples).harmonic.read(signals_.leftCols(samples), omega, speed_m_s, readings, quiet);
}

DriveMoments SectionBuffer::moments(Eigen::Index samples, const Eigen::Vector4d& omega, double speed_m_s) {
  const Taper& taper = window(samples).taper;
  DriveMoments sum;
  sum.count(seconds(samples), speed_m_s);
  add_chassis(sum, taper);
  for (int wheel = 0; wheel < kWheels; ++wheel) add_tyre(sum, taper, wheel, omega(wheel));
  return sum;
}

void SectionBuffer::add_chassis(DriveMoments& sum, const Taper& taper) const {
  const auto z = signals_.block(0, chassis_lag_, kCoordinates, taper.value.size());
  for (int j = 0; j < kChassisInstrumentsPerSignal; ++j) {
    const auto w = tapered<kCoordinates, kCoordinates>(chassis_states_, j * kCoordinates,
                                                       chassis_instrument().corner_hz, taper);
    const Eigen::Matrix<double, 3 * kCoordinates, kCoordinates> products = w * z.transpose();
    for (int s = 0; s < kCoordinates; ++s) {
      const auto i = static_cast<std::size_t>(j * kCoordinates + s);
      sum.chassis[i] = {products.row(s), products.row(kCoordinates + s), products.row(2 * kCoordinates + s)};
      sum.chassis_power[i] = w.row(s).squaredNorm();
    }
  }
}

void SectionBuffer::add_tyre(DriveMoments& sum, const Taper& taper, int wheel, double omega) const {
  const auto w = tapered<1, kWheels>(tyre_states_, wheel, tyre_instrument().corner_hz, taper);
  const Eigen::Matrix<double, 3, kSignals> products =
      w * signals_.middleCols(tyre_lag_, taper.value.size()).transpose();
  const auto z = products.leftCols<kCoordinates>();
  auto& moments = sum.wheel[static_cast<std::size_t>(wheel)];
  moments.tyre = {z.row(0), z.row(1), z.row(2)};
  moments.tyre_unbalance =
      omega * omega * std::complex<double>(products(0, cosine_row(wheel)), products(0, sine_row(wheel)));
}

}  // namespace roadbalance
