#include "host/analysis/identify/drive_posterior.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include <Eigen/SVD>

#include "host/analysis/identify/section_buffer.hpp"
#include "host/analysis/identify/transients.hpp"

namespace roadbalance {
namespace {

using Eigen::Index;

constexpr double kClass_m_s = 1.0;
constexpr double kSection_s = 10.0;  ///< of lines, about
constexpr double kLeastSection_s = 4.0;
constexpr double kLeastQuiet = 0.3;  ///< of a section
constexpr double kLeastSegments = 4.0;

/// Where the car is along the road at each sample, m.
Eigen::ArrayXd distance_of(const Stretch& stretch) {
  Eigen::ArrayXd distance = Eigen::ArrayXd::Zero(stretch.signals.cols());
  Index timer = 0;
  stretch.omega.maxCoeff(&timer);
  const int wheel = static_cast<int>(timer);
  const double m_per_rad = stretch.speed_m_s / stretch.omega(timer);
  for (Index k = 1; k < distance.size(); ++k)
    distance(k) =
        distance(k - 1) + m_per_rad * std::arg(reference(stretch.signals.col(k), wheel) *
                                               std::conj(reference(stretch.signals.col(k - 1), wheel)));
  return distance;
}

/// Readings, and behind them the struts' signals [channel + kStrutSignals x sample].
Eigen::MatrixXd with_struts(const Stretch& stretch, const CarPrior& prior) {
  const Index channels = stretch.readings.rows();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(prior.sensors, Eigen::ComputeThinU | Eigen::ComputeThinV);
  StrutMotion struts(strut_stretch(prior.geometry) * svd.solve(Eigen::MatrixXd::Identity(channels, channels)),
                     stretch.rate_hz);
  Eigen::MatrixXd signals(channels + kStrutSignals, stretch.readings.cols());
  signals.topRows(channels) = stretch.readings;
  for (Index k = 0; k < signals.cols(); ++k)
    struts.update(stretch.readings.col(k).array(), signals.col(k).tail(kStrutSignals).array());
  return signals;
}

Eigen::MatrixXd motion_of(const Eigen::MatrixXd& signals, double rate_hz) {
  const Index channels = signals.rows() - kStrutSignals;
  MotionIntegrals integrals(channels, kStrutSignals, rate_hz);
  Eigen::MatrixXd motion(3 * channels + kStrutSignals, signals.cols());
  for (Index k = 0; k < motion.cols(); ++k) integrals.update(signals.col(k).array(), motion.col(k).array());
  return motion;
}

/// Readings of the channels on the wheels' carriers.
Eigen::MatrixXd carriers_of(const Stretch& stretch, const Eigen::MatrixXd& sensors) {
  std::vector<Index> rows;
  for (Index c = 0; c < sensors.rows(); ++c)
    if (!sensors.row(c).tail<kWheels>().isZero()) rows.push_back(c);
  return stretch.readings(rows, Eigen::all);
}

}  // namespace

void DrivePosterior::add(const Stretch& stretch) {
  if (!(stretch.omega.maxCoeff() > 0.0)) return;
  if (!spectra_)
    spectra_.emplace(prior_.sensors.rows(), prior_.geometry.x_m[0] - prior_.geometry.x_m[2], stretch.rate_hz);
  const auto settling = static_cast<Index>(std::lround(StrutMotion::kSettling_s * stretch.rate_hz));
  const Eigen::ArrayXd quiet = quiet_samples(carriers_of(stretch, prior_.sensors), stretch.rate_hz);
  cut_s_ += static_cast<double>(quiet.size()) / stretch.rate_hz - quiet.sum() / stretch.rate_hz;
  const Eigen::MatrixXd signals = with_struts(stretch, prior_);
  const Index rest = stretch.readings.cols() - settling;
  if (rest > 0) {
    const Eigen::MatrixXd motion = motion_of(signals, stretch.rate_hz);
    SpectralMoments moments = spectra_->moments(motion.rightCols(rest), distance_of(stretch).tail(rest),
                                                quiet.tail(rest), stretch.omega);
    if (moments.segments > 0.0) speeds_[static_cast<int>(stretch.speed_m_s / kClass_m_s)] += moments;
  }
  add_lines(stretch, signals, quiet, settling);
}

void DrivePosterior::add_lines(const Stretch& stretch, const Eigen::MatrixXd& signals,
                               const Eigen::ArrayXd& quiet, Index settling) {
  if (!reader_) reader_.emplace(prior_.geometry, stretch.rate_hz);
  const Index all = stretch.signals.cols() - settling;
  if (all < static_cast<Index>(kLeastSection_s * stretch.rate_hz)) return;
  const Index overlap = SectionBuffer::overlap(stretch.rate_hz, all);
  const double wanted = kSection_s * stretch.rate_hz - static_cast<double>(overlap);
  const Index sections = std::max<Index>(1, std::lround(static_cast<double>(all - overlap) / wanted));
  const Index step = (all - overlap) / sections;
  Lines lines{.speed_class = static_cast<int>(stretch.speed_m_s / kClass_m_s), .density = {}, .sections = {}};
  for (Index s = 0; s < sections; ++s) {
    const Index begin = settling + s * step, size = step + overlap;
    const auto quiet_of = quiet.segment(begin, size);
    if (quiet_of.mean() < kLeastQuiet) continue;
    lines.sections.push_back(reader_->read(stretch.signals.middleCols(begin, size),
                                           signals.middleCols(begin, size), quiet_of, stretch.omega,
                                           stretch.speed_m_s));
    lines.density += lines.sections.back().density();
  }
  if (!lines.sections.empty()) lines_.push_back(std::move(lines));
}

std::map<int, LineMoments> DrivePosterior::weighed(const ParameterVector& parameters) const {
  std::map<int, LineMoments> all;
  for (const Lines& lines : lines_)
    for (const LineReading& section : lines.sections)
      all[lines.speed_class] +=
          line_moments(section, prior_.sensors.rows(), lines.density, prior_.geometry, parameters);
  return all;
}

std::optional<PosteriorCar> DrivePosterior::solve() const {
  std::vector<const SpectralMoments*> speeds;
  double segments = 0.0;
  for (const auto& [speed, moments] : speeds_) {
    speeds.push_back(&moments);
    segments += moments.segments;
  }
  if (segments < kLeastSegments) return std::nullopt;
  const CarPosterior car(prior_, std::move(speeds));
  const PosteriorMode mode = posterior_mode(car, Eigen::VectorXd::Zero(car.size()));
  if (!mode.converged) return std::nullopt;
  const UnbalancePosterior heard = unbalance_posterior(car, mode, weighed(car.parameters(mode.v)));
  Eigen::VectorXd v = mode.v;
  v.head(car.known()) = heard.v;
  PosteriorCar result{.parameters = car.parameters(v),
                      .sigma = ParameterVector::Zero(),
                      .gains = car.gains(v),
                      .sigma_gains = Eigen::VectorXd::Zero(car.channels()),
                      .friction_n = Eigen::Vector4d::Zero(),
                      .rebound = Eigen::Vector4d::Zero(),
                      .wheel = heard.wheel,
                      .steps = mode.steps,
                      .cut_s = cut_s_};
  for (int p = 0; p < kParameters; ++p) {
    const Index at = car.place(p);
    if (at < 0) continue;
    const double sigma = prior_.sigma(p) * std::sqrt(heard.covariance(at, at));
    result.sigma(p) = p >= kTyreDamper ? sigma : sigma * result.parameters(p);
  }
  result.friction_n = car.friction_n(v);
  result.rebound = car.rebound(v);
  for (Index c = 0; c < car.channels(); ++c) {
    const Index at = car.place_of_gain(c);
    if (at >= 0) result.sigma_gains(c) = prior_.gain_sigma(c) * std::sqrt(heard.covariance(at, at));
  }
  return result;
}

}  // namespace roadbalance
