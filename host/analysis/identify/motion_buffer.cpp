#include "host/analysis/identify/motion_buffer.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include <Eigen/SVD>

#include "host/analysis/identify/transients.hpp"

namespace roadbalance {
namespace {

using Eigen::Index;

/// The struts' stretch by the channels' readings [4 x channel].
Eigen::MatrixXd stretch_by_channels(const Geometry& geometry, const Eigen::MatrixXd& sensors) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(sensors, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return strut_stretch(geometry) * svd.solve(Eigen::MatrixXd::Identity(sensors.rows(), sensors.rows()));
}

std::vector<Index> on_carriers(const Eigen::MatrixXd& sensors) {
  std::vector<Index> rows;
  for (Index c = 0; c < sensors.rows(); ++c)
    if (!sensors.row(c).tail<kWheels>().isZero()) rows.push_back(c);
  return rows;
}

}  // namespace

MotionBuffer::MotionBuffer(const Geometry& geometry, const Eigen::MatrixXd& sensors, double rate_hz,
                           Index samples)
    : rate_hz_(rate_hz),
      channels_(sensors.rows()),
      carriers_(on_carriers(sensors)),
      struts_(stretch_by_channels(geometry, sensors), rate_hz),
      integrals_(channels_, kStrutSignals, rate_hz),
      gatherer_(channels_, geometry.x_m[0] - geometry.x_m[2], rate_hz),
      hop_(std::max<Index>(1, std::lround(kHannHop * static_cast<double>(gatherer_.size())))),
      with_struts_(channels_ + kStrutSignals),
      moved_(3 * channels_ + kStrutSignals) {
  const Index columns = samples + gatherer_.size();
  readings_.setZero(with_struts_.size(), columns);
  motion_.setZero(moved_.size(), columns);
  turned_rad_.setZero(kWheels, columns);
  settled_.setZero(columns);
  reset();
}

void MotionBuffer::reset() {
  struts_.reset();
  integrals_.reset();
  settling_ = std::lround(StrutMotion::kSettling_s * rate_hz_);
  before_.fill(0.0);
  keep(0);
}

void MotionBuffer::settle(const Eigen::Ref<const Eigen::VectorXd>& readings) {
  with_struts_.head(channels_) = readings;
  struts_.update(readings.array(), with_struts_.tail<kStrutSignals>().array());
  integrals_.update(with_struts_.array(), moved_.array());
  settling_ = std::max<Index>(0, settling_ - 1);
}

void MotionBuffer::push(const Eigen::Ref<const Eigen::VectorXd>& readings, const SignalVector& signals) {
  settle(readings);
  readings_.col(filled_) = with_struts_;
  motion_.col(filled_) = moved_;
  for (int i = 0; i < kWheels; ++i) {
    const std::complex<double> now = reference(signals, i);
    turned_rad_(i, filled_) =
        std::arg(now * std::conj(std::exchange(before_[static_cast<std::size_t>(i)], now)));
  }
  settled_(filled_) = settling_ == 0 ? 1.0 : 0.0;
  ++filled_;
}

void MotionBuffer::keep(Index count) {
  drop(filled_ - count);
  next_ = 0;
  first_ = true;
}

void MotionBuffer::go_on(Index shared) {
  drop(std::min(next_, filled_ - shared));
}

void MotionBuffer::drop(Index count) {
  const Index rest = filled_ - count;
  readings_.leftCols(rest) = readings_.middleCols(count, rest).eval();
  motion_.leftCols(rest) = motion_.middleCols(count, rest).eval();
  turned_rad_.leftCols(rest) = turned_rad_.middleCols(count, rest).eval();
  settled_.head(rest) = settled_.segment(count, rest).eval();
  filled_ = rest;
  next_ = std::max<Index>(0, next_ - count);
}

Eigen::ArrayXd MotionBuffer::quiet(Index behind) const {
  const Index count = filled_ - behind;
  return quiet_samples(readings_.leftCols(count)(carriers_, Eigen::all), rate_hz_);
}

SpectralMoments MotionBuffer::take(const Eigen::ArrayXd& quiet, const Eigen::Vector4d& omega, int timer,
                                   double rolling_radius_m) {
  SpectralMoments sum;
  const Index size = gatherer_.size();
  for (; next_ + size <= quiet.size(); next_ += hop_) {
    if ((quiet.segment(next_, size) * settled_.segment(next_, size) == 0.0).any()) continue;
    const double rate_rad_s = turned_rad_.row(timer).segment(next_ + 1, size - 1).mean() * rate_hz_;
    gatherer_.add(sum, motion_.middleCols(next_, size), std::exchange(first_, false) ? kHannAlone : kHannHop,
                  omega, rate_rad_s * rolling_radius_m);
  }
  return sum;
}

}  // namespace roadbalance
