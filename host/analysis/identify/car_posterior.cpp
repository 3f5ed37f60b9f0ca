#include "host/analysis/identify/car_posterior.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "common/vehicle/contact_patch.hpp"
#include "common/vehicle/sensor_map.hpp"
#include "host/analysis/identify/estimate_covariance.hpp"
#include "host/analysis/identify/signals.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRoadFrom_hz =
    3.0;  ///< below it the body moves most, and the wheels' rows lack what drives it
constexpr double kBodyTo_hz = 20.0;        ///< above it the body is not rigid
constexpr double kBand_hz = 4.0;           ///< of one level of the body's residuals
constexpr double kLeastNoise_m_s2 = 0.01;  ///< of a sensor, in all of the identification's band
constexpr int kSides = 2;
constexpr int kKnots = 9;
constexpr int kShape = kKnots - 1;  ///< unknowns of a curve: its slope, and each inner knot
constexpr int kCurves = 4;          ///< of the road: shapes of left and right, mixing of sides and of axles
constexpr double kFirstKnot_1_m = 0.075, kLastKnot_1_m = 1.6;
constexpr double kReference_1_m = 0.6;  ///< where slope and level are independent
constexpr double kMixing =
    0.3;  ///< a curve's sigma beside a shape's: coherence from 0.95 to 0.2 within a decade
constexpr int kRows = 2 * kWheels;  ///< of a road: forces, and heights, of the four wheels

constexpr bool is_tyre_damper(int parameter) {
  return parameter >= kTyreDamper;
}

double log_knot(int k) {
  const double first = std::log(kFirstKnot_1_m);
  return first + (std::log(kLastKnot_1_m) - first) * k / (kKnots - 1);
}

/// Second differences of b by its inner knots.
MatrixXd second_differences() {
  MatrixXd all = MatrixXd::Zero(kKnots - 2, kKnots);
  for (int k = 0; k < kKnots - 2; ++k) all.block<1, 3>(k, k) << 1.0, -2.0, 1.0;
  return all.middleCols(1, kKnots - 2);
}

/// left x right^T
MatrixXcd sandwich(const MatrixXd& left, const MatrixXcd& x, const MatrixXd& right) {
  MatrixXcd all(left.rows(), right.rows());
  all.real() = left * x.real() * right.transpose();
  all.imag() = left * x.imag() * right.transpose();
  return all;
}

/// x right^T
MatrixXcd onto(const MatrixXcd& x, const MatrixXd& right) {
  MatrixXcd all(x.rows(), right.rows());
  all.real() = x.real() * right.transpose();
  all.imag() = x.imag() * right.transpose();
  return all;
}

/// left x
MatrixXcd rows_of(const MatrixXd& left, const MatrixXcd& x) {
  MatrixXcd all(left.rows(), x.cols());
  all.real() = left * x.real();
  all.imag() = left * x.imag();
  return all;
}

/// Swaps left and right, and front and rear: they commute, and exp of neither changes a determinant.
Eigen::Matrix4d swap_sides() {
  Eigen::Matrix4d swap = Eigen::Matrix4d::Zero();
  swap(0, 1) = swap(1, 0) = swap(2, 3) = swap(3, 2) = 1.0;
  return swap;
}
Eigen::Matrix4d swap_axles() {
  Eigen::Matrix4d swap = Eigen::Matrix4d::Zero();
  swap(0, 2) = swap(2, 0) = swap(1, 3) = swap(3, 1) = 1.0;
  return swap;
}

/// exp(amount swap)
Eigen::Matrix4d mixing(double amount, const Eigen::Matrix4d& swap) {
  return std::cosh(amount) * Eigen::Matrix4d::Identity() + std::sinh(amount) * swap;
}

constexpr double scale_of_curve(int curve) {
  return curve < kSides ? 1.0 : kMixing;
}

}  // namespace

/// Rows on [y; integral y; double integral y]: the body's residuals, forces on the wheels without tyres,
/// heights of the wheels.
struct CarPosterior::Equations {
  MatrixXd rows;  ///< [residuals + 8 x 3 channels]
  Eigen::Vector4d tyre, tyre_damper;

  Complex tyre_at(Index wheel, double omega) const { return tyre(wheel) + kJ * omega * tyre_damper(wheel); }
};

/// The equations at one frequency.
struct CarPosterior::Bin {
  Eigen::ArrayXd unbracketed;  ///< [motion]
  Eigen::ArrayXd by_bracket;   ///< [channel] its logarithm's derivative by that unknown
  MatrixXcd integral;          ///< [motion x channels]
  MatrixXcd residual;          ///< R
  MatrixXcd force;             ///< [4 x channels]
  Eigen::Vector4cd softness;   ///< 1 / c
  /// Forces and heights of the four wheels, of the front ones, of the rear ones to the road: [diag(1 / c),
  /// 1].
  Eigen::Matrix<Complex, kWheels, kRows> to_road;
  Eigen::Matrix<Complex, 2, kWheels> to_front, to_rear;
  MatrixXcd from_road;      ///< [channels x 4] accelerations per road where nothing is left over
  MatrixXcd from_residual;  ///< [channels x residuals] and per residual: both together [U; R]^-1
  MatrixXcd weight;         ///< (R R^H)^-1
  double log_determinant;   ///< log det R R^H - 2 log |det [U; R]|

  Bin(const Equations& of, Index residuals, Index channels, double omega, const MatrixXcd& integral_of,
      Eigen::ArrayXd unbracketed_of)
      : unbracketed(std::move(unbracketed_of)),
        by_bracket(Eigen::ArrayXd::Zero(channels)),
        integral(unbracketed.matrix().cast<Complex>().asDiagonal() * integral_of) {
    residual = rows_of(of.rows.topRows(residuals), integral);
    force = rows_of(of.rows.middleRows(residuals, kWheels), integral);
    for (Index i = 0; i < kWheels; ++i) softness(i) = 1.0 / of.tyre_at(i, omega);
    to_road << Eigen::Matrix4cd(softness.asDiagonal()), Eigen::Matrix4cd::Identity();
    to_front << Eigen::Matrix2cd(softness.head<2>().asDiagonal()), Eigen::Matrix2cd::Identity();
    to_rear << Eigen::Matrix2cd(softness.tail<2>().asDiagonal()), Eigen::Matrix2cd::Identity();
    MatrixXcd all(channels, channels);
    all.topRows(kWheels) = softness.asDiagonal() * force + rows_of(of.rows.bottomRows(kWheels), integral);
    all.bottomRows(residuals) = residual;
    const Eigen::PartialPivLU<MatrixXcd> lu(all);
    const MatrixXcd inverse = lu.inverse();
    from_road = inverse.leftCols(kWheels);
    from_residual = inverse.rightCols(residuals);
    const Eigen::LLT<MatrixXcd> llt(residual * residual.adjoint());
    weight = llt.solve(MatrixXcd::Identity(residuals, residuals));
    log_determinant = 2.0 * MatrixXcd(llt.matrixL()).diagonal().real().array().log().sum() -
                      2.0 * lu.matrixLU().diagonal().array().abs().log().sum();
  }

  /// Of motion, the share of the brackets taken off.
  MatrixXcd without_brackets(const MatrixXcd& x) const {
    return unbracketed.matrix().cast<Complex>().asDiagonal() * x *
           unbracketed.matrix().cast<Complex>().asDiagonal();
  }
};

/// All that a place in the space of unknowns makes of the equations.
struct CarPosterior::System {
  Equations equations;
  MatrixXd residual_rows, road_rows;
  MatrixXd front_rows, rear_rows;  ///< forces and heights of the front wheels, and of the rear ones
  std::vector<Bin> bin;
};

/// Bins in which the body's residuals are of one level.
struct CarPosterior::Band {
  std::vector<Index> bins;
  double power = 0.0, count = 0.0;
  double level = 0.0;  ///< (m/s^2)^2 / Hz
};

/// The road at one speed.
struct CarPosterior::Roads {
  std::vector<Index> bins;             ///< that count
  std::vector<Eigen::Matrix4cd> road;  ///< [of bins] sum of u u^H, the rear wheels advanced
  std::vector<Complex> later;  ///< [of bins] of front against rear: what the delay is longer than was thought
  std::vector<Eigen::Matrix4d> whitening;  ///< [of bins] W phi^-1/2
  double log_shape = 0.0;                  ///< sum of n log phi over bins and wheels
  Eigen::Matrix4d level = Eigen::Matrix4d::Zero();
  double count = 0.0;
};

/// Derivatives of J by the equations.
struct CarPosterior::Slopes {
  MatrixXd by_residual, by_road;  ///< dJ = 2 tr(d rows * these)
  MatrixXcd by_softness;          ///< [bin x wheel] dJ = Re sum these d(1 / c)
  VectorXd by_bracket;            ///< [channel] of a bracket's unknown

  /// What a bin's rows [r x motion] give, of which dJ = 2 tr(d rows * by_rows).
  void add_brackets(const MatrixXd& rows, const MatrixXd& by_rows, const Bin& bin) {
    const VectorXd by_motion = rows.transpose().cwiseProduct(by_rows).rowwise().sum();
    const Index channels = by_bracket.size();
    for (int k = 0; k < 3; ++k)
      by_bracket.array() += 2.0 * bin.by_bracket * by_motion.segment(k * channels, channels).array();
  }
};

Eigen::ArrayXd unbracketed(const VectorXd& brackets_s2, Index motion, double omega) {
  const double f_hz = omega / (2.0 * std::numbers::pi);
  Eigen::ArrayXd factors = Eigen::ArrayXd::Ones(motion);
  for (int k = 0; k < 3; ++k)
    factors.segment(k * brackets_s2.size(), brackets_s2.size()) -= f_hz * f_hz * brackets_s2.array();
  return factors;
}

CarPrior CarPrior::of(const VehicleConfig& vehicle) {
  constexpr double kStiffness = 0.3, kDamping = 0.5;
  const Priors known = Priors::of(vehicle);
  const SensorMap sensors = SensorMap::from(vehicle);
  CarPrior prior{.geometry = known.geometry,
                 .value = known.value,
                 .sigma = known.sigma,
                 .sensors = sensors.readings,
                 .gain_sigma = Eigen::VectorXd(std::ssize(sensors.input)),
                 .noise_m2_s4_hz = 0.0};
  prior.sigma.head<kSpring>() = known.sigma.head<kSpring>().cwiseQuotient(known.value.head<kSpring>());
  prior.sigma.segment<kWheels>(kSpring).setConstant(kStiffness);
  prior.sigma.segment<kTyre - kDamper>(kDamper).setConstant(kDamping);
  prior.sigma.segment<kWheels>(kTyre).setConstant(kStiffness);
  for (std::size_t s = 0; s < sensors.input.size(); ++s) {
    const NodeConfig& node = vehicle.node[static_cast<std::size_t>(sensors.input[s].node)];
    const ChannelConfig& channel = node.channel[static_cast<std::size_t>(sensors.input[s].channel)];
    prior.gain_sigma(static_cast<Index>(s)) = channel.gain_sigma;
  }
  prior.friction_sigma_n = 50.0;
  prior.rebound_sigma = 0.5;
  prior.strut_sigma = 0.2;
  constexpr double kBracket_hz = 130.0;
  prior.bracket_sigma_s2 = 1.0 / (kBracket_hz * kBracket_hz);
  prior.delay_sigma = 0.02;
  prior.noise_m2_s4_hz = kLeastNoise_m_s2 * kLeastNoise_m_s2 / vehicle.drive.identification_rate_hz;
  return prior;
}

CarPosterior::CarPosterior(const CarPrior& prior, std::vector<SpeedOnRoad> speeds)
    : prior_(prior),
      speeds_(std::move(speeds)),
      channels_(prior.sensors.rows()),
      motion_(3 * channels_ + kStrutSignals),
      bins_(speeds_.front().spectra->bins()),
      residuals_(channels_ - kWheels),
      known_(0) {
  for (int p = 0; p < kParameters; ++p) {
    unit_[static_cast<std::size_t>(p)] = linear_model(prior.geometry, ParameterVector::Unit(p));
    place_[static_cast<std::size_t>(p)] = prior.sigma(p) > 0.0 ? std::ssize(parameter_) : -1;
    if (prior.sigma(p) > 0.0) parameter_.push_back(p);
  }
  for (Index c = 0; c < channels_; ++c)
    if (prior.gain_sigma(c) > 0.0) channel_.push_back(c);
  known_ = std::ssize(parameter_) + std::ssize(channel_);
  if (prior.friction_sigma_n > 0.0) friction_ = std::exchange(known_, known_ + kWheels);
  if (prior.rebound_sigma > 0.0) rebound_ = std::exchange(known_, known_ + kWheels);
  if (prior.strut_sigma > 0.0) strut_ = known_++;
  if (prior.bracket_sigma_s2 > 0.0) bracket_ = std::exchange(known_, known_ + channels_);
  for (const SpeedOnRoad& speed : speeds_) roads_ = std::max(roads_, speed.road + 1);
  size_ = curves_of(roads_) + (prior.delay_sigma > 0.0 ? std::ssize(speeds_) : 0);
  const Eigen::JacobiSVD<MatrixXd> svd(prior.sensors, Eigen::ComputeFullU | Eigen::ComputeFullV);
  coordinates_ = svd.solve(MatrixXd::Identity(channels_, channels_));
  rigid_ = svd.matrixU().rightCols(channels_ - kCoordinates).transpose();
  count_.setZero(bins_);
  same_.assign(static_cast<std::size_t>(bins_), MatrixXcd::Zero(motion_, motion_));
  for (const SpeedOnRoad& speed : speeds_) {
    count_ += speed.spectra->count;
    for (Index k = 0; k < bins_ && is_of_body(k); ++k)
      same_[static_cast<std::size_t>(k)] += speed.spectra->same[static_cast<std::size_t>(k)];
  }
  scale_ << prior.value(kBodyMass), prior.value(kRollInertia), prior.value(kPitchInertia);
  linearise_struts_by_rates();
}

ParameterVector CarPosterior::parameters(const VectorXd& v) const {
  ParameterVector parameters = prior_.value;
  for (std::size_t a = 0; a < parameter_.size(); ++a) {
    const int p = parameter_[a];
    const double step = prior_.sigma(p) * v(static_cast<Index>(a));
    parameters(p) = is_tyre_damper(p) ? prior_.value(p) + step : prior_.value(p) * std::exp(step);
  }
  return parameters;
}

VectorXd CarPosterior::gains(const VectorXd& v) const {
  VectorXd gains = VectorXd::Ones(channels_);
  for (std::size_t a = 0; a < channel_.size(); ++a)
    gains(channel_[a]) =
        std::exp(prior_.gain_sigma(channel_[a]) * v(std::ssize(parameter_) + static_cast<Index>(a)));
  return gains;
}

/// Place of a road's curves among the unknowns.
Index CarPosterior::curves_of(int road) const {
  return known_ + road * kCurves * kShape;
}

/// Place of a speed's delay among the unknowns; -1: it is known exactly.
Index CarPosterior::delay_of(Index speed) const {
  return prior_.delay_sigma > 0.0 ? curves_of(roads_) + speed : -1;
}

double CarPosterior::delay_share(const VectorXd& v, Index speed) const {
  const Index at = delay_of(speed);
  return at < 0 ? 0.0 : prior_.delay_sigma * v(at);
}

bool CarPosterior::is_of_body(Index bin) const {
  return omega(bin) <= 2.0 * std::numbers::pi * kBodyTo_hz * (1.0 + 1e-9);
}

bool CarPosterior::is_of_road(Index bin) const {
  return omega(bin) >= 2.0 * std::numbers::pi * kRoadFrom_hz * (1.0 - 1e-9);
}

CarPosterior::Equations CarPosterior::equations(const VectorXd& v) const {
  const ParameterVector parameters = this->parameters(v);
  ParameterVector without_tyres = parameters;
  without_tyres.segment<2 * kWheels>(kTyre).setZero();
  const LinearModel model = linear_model(prior_.geometry, without_tyres);
  const Eigen::ArrayXd gain = gains(v).array().inverse();
  const MatrixXd coordinates = coordinates_ * gain.matrix().asDiagonal();
  Equations of{MatrixXd::Zero(residuals_ + kRows, motion_), parameters.segment<kWheels>(kTyre),
               parameters.segment<kWheels>(kTyreDamper)};
  const std::array<const Matrix7*, 3> matrix{&model.M, &model.P, &model.Q};
  for (int k = 0; k < 3; ++k) {
    const MatrixXd forces = *matrix[static_cast<std::size_t>(k)] * coordinates;
    auto columns = of.rows.middleCols(k * channels_, channels_);
    columns.topRows(kBodyCoordinates) = scale_.cwiseInverse().asDiagonal() * forces.topRows(kBodyCoordinates);
    columns.middleRows(residuals_, kWheels) = forces.bottomRows(kWheels);
  }
  of.rows.block(kBodyCoordinates, 0, residuals_ - kBodyCoordinates, channels_) =
      rigid_ * gain.matrix().asDiagonal();
  of.rows.block(residuals_ + kWheels, 2 * channels_, kWheels, channels_) = coordinates.bottomRows(kWheels);
  of.rows.rightCols(kStrutSignals) << strut_columns(friction_n(v)),
      strut_columns(rebound(v).cwiseProduct(parameters.segment<kWheels>(kDamper)));
  scale_strut_rests(of.rows, strut_factor(v));
  return of;
}

/// Forces of the struts onto the rows of body and wheels.
MatrixXd CarPosterior::strut_columns(const Eigen::Vector4d& force) const {
  const Eigen::Matrix<double, kCoordinates, kWheels> onto = stretch_.transpose() * force.asDiagonal();
  MatrixXd columns = MatrixXd::Zero(residuals_ + kRows, kWheels);
  columns.topRows(kBodyCoordinates) = scale_.cwiseInverse().asDiagonal() * onto.topRows(kBodyCoordinates);
  columns.middleRows(residuals_, kWheels) = onto.bottomRows(kWheels);
  return columns;
}

/// Motion per acceleration of the channels at a circular frequency.
MatrixXcd CarPosterior::integrals(double omega) const {
  MatrixXcd all = MatrixXcd::Zero(motion_, channels_);
  const auto unit = MatrixXcd::Identity(channels_, channels_);
  all.topRows(channels_) = unit;
  all.middleRows(channels_, channels_) = unit / (kJ * omega);
  all.middleRows(2 * channels_, channels_) = -unit / (omega * omega);
  const MatrixXd rates = stretch_ * coordinates_;
  all.bottomRows(kStrutSignals) = linear_ * rates / (kJ * omega) + leading_ * rates;
  return all;
}

Eigen::Vector4d CarPosterior::friction_n(const VectorXd& v) const {
  if (friction_ < 0) return Eigen::Vector4d::Zero();
  return prior_.friction_sigma_n * v.segment<kWheels>(friction_);
}

Eigen::Vector4d CarPosterior::rebound(const VectorXd& v) const {
  if (rebound_ < 0) return Eigen::Vector4d::Zero();
  return prior_.rebound_sigma * v.segment<kWheels>(rebound_);
}

/// By the regression on the rates.
void CarPosterior::linearise_struts_by_rates() {
  stretch_ = strut_stretch(prior_.geometry);
  linear_.setZero();
  leading_.setZero();
  MatrixXd rates = MatrixXd::Zero(kWheels, motion_);
  rates.middleCols(channels_, channels_) = stretch_ * coordinates_;
  Eigen::Matrix<double, kStrutSignals, kWheels> with = linear_;
  Eigen::Vector4d power = Eigen::Vector4d::Zero();
  for (Index k = 0; k < bins_ && is_of_body(k); ++k) {
    const MatrixXd x = same_[static_cast<std::size_t>(k)].real();
    with += x.bottomRows(kStrutSignals) * rates.transpose();
    power += (rates * x * rates.transpose()).diagonal();
  }
  for (int i = 0; i < kWheels; ++i)
    if (power(i) > 0.0)
      for (const int row : {i, kWheels + i}) linear_(row, i) = with(row, i) / power(i);
}

void CarPosterior::linearise_struts(const VectorXd& v) {
  const System of = system(v);
  MatrixXd rows = MatrixXd::Zero(kWheels + kStrutSignals, motion_);  // rates of the struts, and their signals
  rows.block(0, channels_, kWheels, channels_) = stretch_ * coordinates_;
  rows.bottomRightCorner<kStrutSignals, kStrutSignals>().setIdentity();
  using Sums = Eigen::Array<double, kStrutSignals, 1>;
  Sums constant = Sums::Zero(), leading = Sums::Zero(), count = Sums::Zero(), squares = Sums::Zero();
  for (Index k = 0; k < bins_; ++k) {
    if (!is_of_road(k)) continue;
    const Bin& bin = of.bin[static_cast<std::size_t>(k)];
    const MatrixXcd road = bin.to_road * of.road_rows * bin.unbracketed.matrix().asDiagonal();
    for (const SpeedOnRoad& speed : speeds_) {
      if (speed.spectra->count(k) <= 0.0) continue;
      const MatrixXcd& x = speed.spectra->same[static_cast<std::size_t>(k)];
      const MatrixXcd onto_road = x * road.adjoint();
      const MatrixXcd with_road = rows * onto_road;
      const Eigen::LDLT<Eigen::Matrix4cd> power(road * onto_road);
      const MatrixXcd explained = power.solve(with_road.topRows(kWheels).adjoint());  // [4 x rate]
      for (Index s = 0; s < kStrutSignals; ++s) {
        const Index i = s % kWheels;
        const double rate = (with_road.row(i) * explained.col(i)).value().real();
        const Complex c = (with_road.row(kWheels + s) * explained.col(i)).value() / rate;
        if (!std::isfinite(std::abs(c))) continue;
        const double weight = speed.spectra->count(k);
        constant(s) += weight * c.real();
        leading(s) += weight * omega(k) * c.imag();
        count(s) += weight;
        squares(s) += weight * omega(k) * omega(k);
      }
    }
  }
  for (Index s = 0; s < kStrutSignals; ++s) {
    if (count(s) <= 0.0) continue;
    linear_(s, s % kWheels) = constant(s) / count(s);
    leading_(s, s % kWheels) = leading(s) / squares(s);
  }
}

std::vector<UncertainQuantity> CarPosterior::quantities() const {
  using Kind = UncertainQuantity::Kind;
  std::vector<UncertainQuantity> all;
  for (const int p : parameter_) all.push_back({Kind::kParameter, p});
  for (const Index c : channel_) all.push_back({Kind::kGain, c});
  for (Index i = 0; i < kWheels && friction_ >= 0; ++i) all.push_back({Kind::kFriction, i});
  for (Index i = 0; i < kWheels && rebound_ >= 0; ++i) all.push_back({Kind::kRebound, i});
  if (strut_ >= 0) all.push_back({Kind::kStruts, 0});
  for (Index c = 0; c < channels_ && bracket_ >= 0; ++c) all.push_back({Kind::kBracket, c});
  return all;
}

VectorXd CarPosterior::brackets_s2(const VectorXd& v) const {
  if (bracket_ < 0) return VectorXd::Zero(channels_);
  return prior_.bracket_sigma_s2 * v.segment(bracket_, channels_);
}

/// Derivative of the equations' rows by an unknown in a bin, on motion without the brackets' share.
MatrixXd CarPosterior::rows_at(const System& of, const std::vector<MatrixXd>& rows_by, Index unknown,
                               Index bin) const {
  if (bracket_ < 0 || unknown < bracket_) return rows_by[static_cast<std::size_t>(unknown)];
  const Index c = unknown - bracket_;
  const MatrixXd& rows = of.equations.rows;
  MatrixXd by = MatrixXd::Zero(rows.rows(), rows.cols());
  for (int k = 0; k < 3; ++k)
    by.col(k * channels_ + c) =
        of.bin[static_cast<std::size_t>(bin)].by_bracket(c) * rows.col(k * channels_ + c);
  return by;
}

double CarPosterior::strut_factor(const VectorXd& v) const {
  return strut_ < 0 ? 1.0 : std::exp(prior_.strut_sigma * v(strut_));
}

/// Of the struts' signals in the wheels' rows, takes `factor` of what they are beyond their linear elements.
void CarPosterior::scale_strut_rests(MatrixXd& rows, double factor) const {
  auto signals = rows.block(residuals_, 3 * channels_, kWheels, kStrutSignals);
  const MatrixXd less = (1.0 - factor) * signals, rates = stretch_ * coordinates_;
  rows.block(residuals_, 0, kWheels, channels_) += less * leading_ * rates;
  rows.block(residuals_, channels_, kWheels, channels_) += less * linear_ * rates;
  signals *= factor;
}

MatrixXd CarPosterior::wheel_forces(const VectorXd& v) const {
  Equations of = equations(v);
  scale_strut_rests(of.rows, 1.0 / strut_factor(v));
  MatrixXd forces = of.rows.middleRows(residuals_, kWheels);
  const MatrixXd heights = of.rows.block(residuals_ + kWheels, 2 * channels_, kWheels, channels_);
  forces.middleCols(channels_, channels_) += of.tyre_damper.asDiagonal() * heights;
  forces.middleCols(2 * channels_, channels_) += of.tyre.asDiagonal() * heights;
  return forces;
}

/// Derivative of Equations::rows by an unknown of car or sensors.
MatrixXd CarPosterior::equations_by(const VectorXd& v, const Equations& of, Index unknown) const {
  MatrixXd rows = MatrixXd::Zero(of.rows.rows(), of.rows.cols());
  const double factor = strut_factor(v);
  if (strut_ >= 0 && unknown == strut_) {
    MatrixXd without = of.rows;
    scale_strut_rests(without, 0.0);
    return prior_.strut_sigma * (of.rows - without);
  }
  if (friction_ >= 0 && unknown >= friction_ && unknown < friction_ + kWheels) {
    rows.middleCols(3 * channels_, kWheels) =
        strut_columns(prior_.friction_sigma_n * Eigen::Vector4d::Unit(unknown - friction_));
    scale_strut_rests(rows, factor);
    return rows;
  }
  if (rebound_ >= 0 && unknown >= rebound_ && unknown < rebound_ + kWheels) {
    const Index i = unknown - rebound_;
    rows.rightCols(kWheels) =
        strut_columns(prior_.rebound_sigma * parameters(v)(kDamper + i) * Eigen::Vector4d::Unit(i));
    scale_strut_rests(rows, factor);
    return rows;
  }
  if (unknown >= std::ssize(parameter_)) {
    const Index c = channel_[static_cast<std::size_t>(unknown - std::ssize(parameter_))];
    MatrixXd by_channels = of.rows;  // gains are not in the struts' signals, nor in their linear elements
    scale_strut_rests(by_channels, 1.0 / factor);
    for (int k = 0; k < 3; ++k)
      rows.col(k * channels_ + c) = -prior_.gain_sigma(c) * by_channels.col(k * channels_ + c);
    return rows;
  }
  const int p = parameter_[static_cast<std::size_t>(unknown)];
  if (p >= kTyre) return rows;
  const LinearModel& unit = unit_[static_cast<std::size_t>(p)];
  const double step = prior_.sigma(p) * parameters(v)(p);
  const MatrixXd coordinates = coordinates_ * gains(v).cwiseInverse().asDiagonal();
  const std::array<const Matrix7*, 3> matrix{&unit.M, &unit.P, &unit.Q};
  for (int k = 0; k < 3; ++k) {
    const MatrixXd forces = step * *matrix[static_cast<std::size_t>(k)] * coordinates;
    auto columns = rows.middleCols(k * channels_, channels_);
    columns.topRows(kBodyCoordinates) = scale_.cwiseInverse().asDiagonal() * forces.topRows(kBodyCoordinates);
    columns.middleRows(residuals_, kWheels) = forces.bottomRows(kWheels);
  }
  if (p >= kDamper && p < kStabiliser)
    rows.rightCols(kWheels) =
        strut_columns(step * rebound(v)(p - kDamper) * Eigen::Vector4d::Unit(p - kDamper));
  scale_strut_rests(rows, factor);
  return rows;
}

CarPosterior::System CarPosterior::system(const VectorXd& v) const {
  System of{.equations = equations(v),
            .residual_rows = {},
            .road_rows = {},
            .front_rows = {},
            .rear_rows = {},
            .bin = {}};
  of.residual_rows = of.equations.rows.topRows(residuals_);
  of.road_rows = of.equations.rows.bottomRows(kRows);
  of.front_rows.resize(kWheels, motion_);
  of.front_rows << of.road_rows.topRows(2), of.road_rows.middleRows(kWheels, 2);
  of.rear_rows.resize(kWheels, motion_);
  of.rear_rows << of.road_rows.middleRows(2, 2), of.road_rows.bottomRows(2);
  of.bin.reserve(static_cast<std::size_t>(bins_));
  const VectorXd brackets = brackets_s2(v);
  for (Index k = 0; k < bins_; ++k) {
    of.bin.emplace_back(of.equations, residuals_, channels_, omega(k), integrals(omega(k)),
                        roadbalance::unbracketed(brackets, motion_, omega(k)));
    Bin& bin = of.bin.back();
    const double f_hz = omega(k) / (2.0 * std::numbers::pi);
    bin.by_bracket = -prior_.bracket_sigma_s2 * f_hz * f_hz / bin.unbracketed.head(channels_);
  }
  return of;
}

/// By each unknown of a curve [bin].
std::vector<Eigen::ArrayXd> CarPosterior::curve_by(const SpectralMoments& speed) const {
  std::vector<Eigen::ArrayXd> by(kShape, Eigen::ArrayXd::Zero(bins_));
  const double speed_m_s = (prior_.geometry.x_m[0] - prior_.geometry.x_m[2]) / speed.delay_s();
  for (Index k = 0; k < bins_; ++k) {
    const double log_n = std::log(omega(k) / (2.0 * std::numbers::pi * speed_m_s));
    by[0](k) = -(log_n - std::log(kReference_1_m));
    for (int b = 1; b < kKnots - 1; ++b) {
      const double below = (log_n - log_knot(b - 1)) / (log_knot(b) - log_knot(b - 1));
      const double above = (log_knot(b + 1) - log_n) / (log_knot(b + 1) - log_knot(b));
      by[static_cast<std::size_t>(b)](k) = std::max(0.0, std::min(below, above));
    }
  }
  return by;
}

/// log phi of left and right, mixing of sides and of axles [bin x curve]
MatrixXd CarPosterior::curves(const VectorXd& v, const SpeedOnRoad& speed) const {
  const std::vector<Eigen::ArrayXd> by = curve_by(*speed.spectra);
  const double speed_m_s = (prior_.geometry.x_m[0] - prior_.geometry.x_m[2]) / speed.spectra->delay_s();
  MatrixXd curves = MatrixXd::Zero(bins_, kCurves);
  for (Index k = 0; k < bins_; ++k) {
    const double n = omega(k) / (2.0 * std::numbers::pi * speed_m_s);
    curves.row(k).head<kSides>().setConstant(-2.0 * std::log(n / kReference_1_m) -
                                             std::log1p(std::pow(n / kPatchWave_1_m, 2)));
  }
  for (int c = 0; c < kCurves; ++c)
    for (int b = 0; b < kShape; ++b)
      curves.col(c).array() +=
          scale_of_curve(c) * v(curves_of(speed.road) + c * kShape + b) * by[static_cast<std::size_t>(b)];
  return curves;
}

double CarPosterior::prior_value(const VectorXd& v, VectorXd* gradient) const {
  double value = 0.5 * v.head(known_).squaredNorm();
  if (gradient) gradient->head(known_) += v.head(known_);
  static const MatrixXd kDifferences = second_differences();
  for (int c = 0; c < roads_ * kCurves; ++c) {
    const Index at = known_ + c * kShape;
    const VectorXd bent = kDifferences * v.segment(at + 1, kShape - 1);
    value += 0.5 * v(at) * v(at) + 0.5 * bent.squaredNorm();
    if (!gradient) continue;
    (*gradient)(at) += v(at);
    gradient->segment(at + 1, kShape - 1) += kDifferences.transpose() * bent;
  }
  if (prior_.delay_sigma > 0.0) {
    const Index count = std::ssize(speeds_);
    value += 0.5 * v.tail(count).squaredNorm();
    if (gradient) gradient->tail(count) += v.tail(count);
  }
  return value;
}

double CarPosterior::value(const VectorXd& v) const {
  return evaluate(v, nullptr);
}

double CarPosterior::value(const VectorXd& v, VectorXd& gradient) const {
  return evaluate(v, &gradient);
}

std::vector<CarPosterior::Band> CarPosterior::bands(const System& of) const {
  std::vector<Band> all(static_cast<std::size_t>(std::lround(kBodyTo_hz / kBand_hz)));
  for (Index k = 0; k < bins_ && is_of_body(k); ++k) {
    const double bands = omega(k) / (2.0 * std::numbers::pi * kBand_hz);  // a bin on a border belongs below
    Band& band = all.at(static_cast<std::size_t>(std::max(0.0, std::ceil(bands - 1e-9) - 1.0)));
    const auto b = static_cast<std::size_t>(k);
    band.bins.push_back(k);
    band.count += static_cast<double>(residuals_) * count_(k);
    band.power += (of.bin[b].weight *
                   sandwich(of.residual_rows, of.bin[b].without_brackets(same_[b]), of.residual_rows))
                      .trace()
                      .real();
  }
  std::erase_if(all, [](const Band& band) { return band.count <= 0.0; });
  for (Band& band : all) band.level = std::max(band.power / band.count, prior_.noise_m2_s4_hz);
  return all;
}

CarPosterior::Roads CarPosterior::roads(const System& of, const VectorXd& v, const SpeedOnRoad& on) const {
  const SpectralMoments& speed = *on.spectra;
  const MatrixXd curves = this->curves(v, on);
  Roads roads;
  for (Index k = 0; k < bins_; ++k) {
    if (!is_of_road(k) || speed.count(k) <= 0.0) continue;
    const auto b = static_cast<std::size_t>(k);
    const Bin& bin = of.bin[b];
    Eigen::Matrix4cd u = bin.to_road *
                         sandwich(of.road_rows, bin.without_brackets(speed.same[b]), of.road_rows) *
                         bin.to_road.adjoint();
    const Complex later = std::polar(1.0, -omega(k) * speed.delay_s() * delay_share(v, index_of(on)));
    u.topRightCorner<2, 2>() = later * bin.to_front *
                               sandwich(of.front_rows, bin.without_brackets(speed.delayed[b]), of.rear_rows) *
                               bin.to_rear.adjoint();
    u.bottomLeftCorner<2, 2>() = u.topRightCorner<2, 2>().adjoint().eval();
    const double left = std::exp(-0.5 * curves(k, 0)), right = std::exp(-0.5 * curves(k, 1));
    const Eigen::Matrix4d whitening = mixing(curves(k, 2), swap_sides()) *
                                      mixing(curves(k, 3), swap_axles()) *
                                      Eigen::Vector4d(left, right, left, right).asDiagonal();
    roads.bins.push_back(k);
    roads.road.push_back(u);
    roads.later.push_back(later);
    roads.whitening.push_back(whitening);
    roads.level += whitening * u.real() * whitening.transpose();
    roads.log_shape += 2.0 * speed.count(k) * curves.row(k).head<kSides>().sum();
    roads.count += speed.count(k);
  }
  if (roads.count > 0.0) roads.level /= roads.count;
  return roads;
}

double CarPosterior::evaluate(const VectorXd& v, VectorXd* gradient) const {
  const System of = system(v);
  if (!of.equations.rows.allFinite() || (of.equations.tyre.array() <= 0.0).any())
    return std::numeric_limits<double>::infinity();
  std::optional<Slopes> slopes;
  if (gradient) {
    gradient->setZero(size_);
    slopes = Slopes{MatrixXd::Zero(motion_, residuals_), MatrixXd::Zero(motion_, kRows),
                    MatrixXcd::Zero(bins_, kWheels), VectorXd::Zero(channels_)};
  }
  double value = body_value(of, slopes ? &*slopes : nullptr);
  for (const SpeedOnRoad& speed : speeds_)
    value += road_value(of, v, speed, slopes ? &*slopes : nullptr, gradient);
  if (gradient) add_slopes(of, v, *slopes, *gradient);
  return value + prior_value(v, gradient);
}

double CarPosterior::body_value(const System& of, Slopes* slopes) const {
  double value = 0.0;
  for (const Band& band : bands(of)) {
    value += band.count * std::log(band.level) + band.power / band.level;
    if (!slopes) continue;
    for (const Index k : band.bins) {
      const Bin& bin = of.bin[static_cast<std::size_t>(k)];
      const MatrixXcd x = bin.without_brackets(same_[static_cast<std::size_t>(k)]);
      const MatrixXcd all = sandwich(of.residual_rows, x, of.residual_rows);
      const MatrixXd by_rows = (onto(x, of.residual_rows) * bin.weight -
                                bin.integral * bin.residual.adjoint() * bin.weight * all * bin.weight)
                                   .real() /
                               band.level;
      slopes->by_residual += by_rows;
      slopes->add_brackets(of.residual_rows, by_rows, bin);
    }
  }
  return value;
}

double CarPosterior::road_value(const System& of, const VectorXd& v, const SpeedOnRoad& speed, Slopes* slopes,
                                VectorXd* gradient) const {
  const Roads roads = this->roads(of, v, speed);
  if (roads.count <= 0.0) return 0.0;
  const Eigen::LLT<Eigen::Matrix4d> llt(roads.level);
  if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  double value =
      roads.log_shape + 2.0 * roads.count * Eigen::Matrix4d(llt.matrixL()).diagonal().array().log().sum();
  for (const Index k : roads.bins)
    value += speed.spectra->count(k) * of.bin[static_cast<std::size_t>(k)].log_determinant;
  if (slopes) add_road_slopes(of, speed, roads, *slopes, *gradient);
  return value;
}

void CarPosterior::add_road_slopes(const System& of, const SpeedOnRoad& on, const Roads& roads,
                                   Slopes& slopes, VectorXd& gradient) const {
  const SpectralMoments& speed = *on.spectra;
  const Eigen::Matrix4d inverse = roads.level.llt().solve(Eigen::Matrix4d::Identity());
  MatrixXd by_curve = MatrixXd::Zero(bins_, kCurves);
  const std::array<Eigen::Matrix4d, 2> swap{swap_sides(), swap_axles()};
  for (std::size_t at = 0; at < roads.bins.size(); ++at) {
    const Index k = roads.bins[at];
    const auto b = static_cast<std::size_t>(k);
    const Bin& bin = of.bin[b];
    const double n = speed.count(k);
    const Eigen::Matrix4d& whitening = roads.whitening[at];
    const Eigen::Matrix4d weight = whitening.transpose() * inverse * whitening;
    Eigen::Matrix4d on_axle = weight;
    on_axle.topRightCorner<2, 2>().setZero();
    on_axle.bottomLeftCorner<2, 2>().setZero();
    const Eigen::Matrix2d across = weight.topRightCorner<2, 2>();

    MatrixXd by_residual = MatrixXd::Zero(motion_, residuals_), by_road = MatrixXd::Zero(motion_, kRows);

    // Wheels of one axle.
    const MatrixXcd delayed = roads.later[at] * bin.without_brackets(speed.delayed[b]);
    const MatrixXcd half = onto(bin.without_brackets(speed.same[b]), of.road_rows);
    const MatrixXcd on_map = bin.to_road.adjoint() * on_axle;
    by_road += (half * on_map * bin.to_road).real();
    const MatrixXcd rows_on = rows_of(of.road_rows, half) * on_map;  // [8 x 4]
    // A front wheel and a rear one.
    const Eigen::Matrix4cd back = bin.to_rear.adjoint() * across.transpose() * bin.to_front;
    const MatrixXcd by_front = onto(delayed, of.rear_rows) * back;
    const MatrixXcd by_rear = (back * rows_of(of.front_rows, delayed)).transpose();
    by_road.leftCols(2) += by_front.leftCols(2).real();
    by_road.middleCols(kWheels, 2) += by_front.rightCols(2).real();
    by_road.middleCols(2, 2) += by_rear.leftCols(2).real();
    by_road.rightCols(2) += by_rear.rightCols(2).real();
    const MatrixXcd between = sandwich(of.front_rows, delayed, of.rear_rows);
    const MatrixXcd front_on = between * bin.to_rear.adjoint() * across.transpose();  // [4 x 2]
    const MatrixXcd rear_on = across.transpose() * bin.to_front * between;            // [2 x 4]
    for (Index i = 0; i < kWheels; ++i)
      slopes.by_softness(k, i) +=
          2.0 * (rows_on(i, i) + (i < 2 ? front_on(i, i) : std::conj(rear_on(i - 2, i - 2))) -
                 n * (bin.force.row(i) * bin.from_road.col(i)).value());

    // log det R R^H - 2 log |det [U; R]|
    by_residual += n * (bin.integral * (bin.residual.adjoint() * bin.weight - bin.from_residual)).real();
    const MatrixXcd by_height = bin.integral * bin.from_road;
    by_road.leftCols(kWheels) -= n * (by_height * bin.softness.asDiagonal()).real();
    by_road.rightCols(kWheels) -= n * by_height.real();

    slopes.by_residual += by_residual;
    slopes.by_road += by_road;
    slopes.add_brackets(of.residual_rows, by_residual, bin);
    slopes.add_brackets(of.road_rows, by_road, bin);

    if (const Index delay = delay_of(index_of(on)); delay >= 0)
      gradient(delay) += 2.0 * prior_.delay_sigma * omega(k) * speed.delay_s() *
                         across.cwiseProduct(roads.road[at].imag().topRightCorner<2, 2>()).sum();

    const Eigen::Matrix4d share = weight.cwiseProduct(roads.road[at].real());
    for (int side = 0; side < kSides; ++side)
      by_curve(k, side) = 2.0 * n - share.row(side).sum() - share.row(side + 2).sum();
    const Eigen::Matrix4d white = whitening * roads.road[at].real() * whitening.transpose();
    for (int m = 0; m < 2; ++m)
      by_curve(k, kSides + m) = 2.0 * (inverse * swap[static_cast<std::size_t>(m)] * white).trace();
  }
  const std::vector<Eigen::ArrayXd> by = curve_by(speed);
  for (int c = 0; c < kCurves; ++c)
    for (int b = 0; b < kShape; ++b)
      gradient(curves_of(on.road) + c * kShape + b) +=
          scale_of_curve(c) * (by_curve.col(c).array() * by[static_cast<std::size_t>(b)]).sum();
}

void CarPosterior::add_slopes(const System& of, const VectorXd& v, const Slopes& slopes,
                              VectorXd& gradient) const {
  MatrixXd by_rows(motion_, residuals_ + kRows);
  by_rows << slopes.by_residual, slopes.by_road;
  if (bracket_ >= 0) gradient.segment(bracket_, channels_) += slopes.by_bracket;
  for (Index a = 0; a < (bracket_ < 0 ? known_ : bracket_); ++a)
    gradient(a) += 2.0 * equations_by(v, of.equations, a).transpose().cwiseProduct(by_rows).sum();
  for (std::size_t a = 0; a < parameter_.size(); ++a) {
    const int p = parameter_[a];
    if (p < kTyre) continue;
    const Index wheel = (p - kTyre) % kWheels;
    for (Index k = 0; k < bins_; ++k) {
      const Complex softness = of.bin[static_cast<std::size_t>(k)].softness(wheel);
      gradient(static_cast<Index>(a)) +=
          (slopes.by_softness(k, wheel) * -softness * softness * stiffness_step(of.equations, p, omega(k)))
              .real();
    }
  }
}

/// Change of c = ct + j om dt by a standard deviation of a tyre's stiffness or damper.
std::complex<double> CarPosterior::stiffness_step(const Equations& of, int parameter, double omega) const {
  const double sigma = prior_.sigma(parameter);
  return is_tyre_damper(parameter) ? kJ * omega * sigma
                                   : Complex(sigma * of.tyre((parameter - kTyre) % kWheels));
}

/// How the road that is computed changes by an unknown, per unit of the true one [4 x 4].
/// @param rows  derivative of the equations' rows by it
MatrixXcd CarPosterior::road_by(const System& of, Index k, const MatrixXd& rows, Index unknown) const {
  const Bin& bin = of.bin[static_cast<std::size_t>(k)];
  const MatrixXcd from_road = bin.integral * bin.from_road;
  MatrixXcd road = bin.to_road * rows_of(rows.bottomRows(kRows), from_road);
  if (unknown < std::ssize(parameter_) && parameter_[static_cast<std::size_t>(unknown)] >= kTyre) {
    const int p = parameter_[static_cast<std::size_t>(unknown)];
    const Index wheel = (p - kTyre) % kWheels;
    road.row(wheel) -= bin.softness(wheel) * bin.softness(wheel) * stiffness_step(of.equations, p, omega(k)) *
                       (bin.force.row(wheel) * bin.from_road);
  }
  return road;
}

MatrixXd CarPosterior::information(const VectorXd& v) const {
  const System of = system(v);
  std::vector<MatrixXd> rows_by;
  for (Index a = 0; a < (bracket_ < 0 ? known_ : bracket_); ++a)
    rows_by.push_back(equations_by(v, of.equations, a));
  MatrixXd information = MatrixXd::Zero(size_, size_);
  add_body_information(of, rows_by, information);
  for (const SpeedOnRoad& speed : speeds_) add_road_information(of, v, speed, rows_by, information);
  add_prior_information(information);
  return information.selfadjointView<Eigen::Lower>();
}

/// Of the body's residuals.
void CarPosterior::add_body_information(const System& of, const std::vector<MatrixXd>& rows_by,
                                        MatrixXd& information) const {
  for (const Band& band : bands(of)) {
    for (const Index k : band.bins) {
      const auto b = static_cast<std::size_t>(k);
      const Bin& bin = of.bin[b];
      // Of what was measured, less the noise, which is bin.weight's inverse at the band's level.
      const MatrixXcd x = bin.without_brackets(same_[b]);
      std::vector<MatrixXd> changes;
      for (Index a = 0; a < known_; ++a) changes.push_back(rows_at(of, rows_by, a, k).topRows(residuals_));
      for (std::size_t a = 0; a < changes.size(); ++a) {
        const MatrixXd& change = changes[a];
        const MatrixXcd measured = bin.weight * rows_of(change, x) / band.level;
        const MatrixXcd noise =
            count_(k) * bin.weight * rows_of(change, bin.integral) * bin.integral.adjoint();
        const MatrixXcd signal = measured - noise;
        for (std::size_t c = 0; c <= a; ++c)
          information(static_cast<Index>(a), static_cast<Index>(c)) +=
              2.0 * signal.real().cwiseProduct(changes[c]).sum();
      }
    }
  }
}

/// Gaussian with E[u u^H] = phi L; what could as well be a change of L is taken off.
void CarPosterior::add_road_information(const System& of, const VectorXd& v, const SpeedOnRoad& on,
                                        const std::vector<MatrixXd>& rows_by, MatrixXd& information) const {
  const SpectralMoments& speed = *on.spectra;
  const Roads roads = this->roads(of, v, on);
  if (roads.count <= 0.0) return;
  const std::vector<Eigen::ArrayXd> by = curve_by(speed);
  const std::array<Eigen::Matrix4d, 2> swap{swap_sides(), swap_axles()};
  const Eigen::Matrix4d lower = roads.level.llt().matrixL();
  const Eigen::Matrix4d upward = lower.inverse();
  // Real rows of L^-1/2 S L^-T/2, so that their products are traces.
  constexpr Index kEach = 32;
  constexpr Index kOwn = kCurves * kShape;  // unknowns of this road
  const Index delay = delay_of(index_of(on));
  const Index each = known_ + kOwn + (delay < 0 ? 0 : 1);
  MatrixXd signal(each, kEach * std::ssize(roads.bins)), means = MatrixXd::Zero(each, kEach / 2);
  for (std::size_t at = 0; at < roads.bins.size(); ++at) {
    const Index k = roads.bins[at];
    const double weight = speed.count(k);
    const auto put = [&](Index unknown, const Eigen::Matrix4cd& change) {
      const Eigen::Matrix4cd moved = change * roads.level;
      const Eigen::Matrix4cd white = upward * (moved + moved.adjoint()) * upward.transpose();
      const Eigen::Matrix4d real = white.real(), imaginary = white.imag();
      auto row = signal.row(unknown).segment(kEach * static_cast<Index>(at), kEach);
      row.head<kEach / 2>() = std::sqrt(weight) * real.reshaped().transpose();
      row.tail<kEach / 2>() = std::sqrt(weight) * imaginary.reshaped().transpose();
      means.row(unknown) += weight * real.reshaped().transpose();
    };
    Eigen::Matrix4cd whitening = roads.whitening[at].cast<Complex>();
    whitening.rightCols<2>() *= std::polar(1.0, omega(k) * speed.delay_s()) * std::conj(roads.later[at]);
    const Eigen::Matrix4cd back = whitening.inverse();
    for (Index a = 0; a < known_; ++a)
      put(a, whitening * road_by(of, k, rows_at(of, rows_by, a, k), a) * back);
    for (int c = 0; c < kCurves; ++c) {
      Eigen::Matrix4cd change = Eigen::Matrix4cd::Zero();
      if (c < kSides)
        change = -0.5 * whitening.col(c) * back.row(c) - 0.5 * whitening.col(c + 2) * back.row(c + 2);
      else
        change = swap[static_cast<std::size_t>(c - kSides)].cast<Complex>();
      for (int b = 0; b < kShape; ++b)
        put(known_ + c * kShape + b, scale_of_curve(c) * by[static_cast<std::size_t>(b)](k) * change);
    }
    if (delay < 0) continue;
    const Complex step = kJ * prior_.delay_sigma * omega(k) * speed.delay_s();
    put(known_ + kOwn, whitening * Eigen::Vector4cd(0.0, 0.0, step, step).asDiagonal() * back);
  }
  const MatrixXd all = signal * signal.transpose() - means * means.transpose() / roads.count;
  const Index curves = curves_of(on.road);
  information.topLeftCorner(known_, known_) += all.topLeftCorner(known_, known_);
  information.block(curves, 0, kOwn, known_) += all.block(known_, 0, kOwn, known_);
  information.block(curves, curves, kOwn, kOwn) += all.block(known_, known_, kOwn, kOwn);
  if (delay < 0) return;
  information.row(delay).head(known_) += all.row(known_ + kOwn).head(known_);
  information.row(delay).segment(curves, kOwn) += all.row(known_ + kOwn).segment(known_, kOwn);
  information(delay, delay) += all(known_ + kOwn, known_ + kOwn);
}

void CarPosterior::add_prior_information(MatrixXd& information) const {
  information.diagonal().head(known_).array() += 1.0;
  static const MatrixXd kDifferences = second_differences();
  for (int c = 0; c < roads_ * kCurves; ++c) {
    const Index at = known_ + c * kShape;
    information(at, at) += 1.0;
    information.block(at + 1, at + 1, kShape - 1, kShape - 1) += kDifferences.transpose() * kDifferences;
  }
  if (prior_.delay_sigma > 0.0) information.diagonal().tail(std::ssize(speeds_)).array() += 1.0;
}

namespace {

/// Newton's step, damped until it leads no further than the information is good for (Levenberg).
/// @param information  damped alike on return
VectorXd bounded_step(MatrixXd& information, const VectorXd& gradient) {
  constexpr double kFarthest = 1.5;  ///< standard deviations of a prior
  for (double damping = 1.0; damping < 1e12; damping *= 4.0) {
    const VectorXd step = -information.ldlt().solve(gradient);
    if (step.allFinite() && step.cwiseAbs().maxCoeff() <= kFarthest) return step;
    information.diagonal().array() += damping;
  }
  return VectorXd::Zero(gradient.size());
}

/// Where the expected curvature is not the true one, the steps themselves show by how much.
///
/// Source: J. Nocedal, S. J. Wright, Numerical Optimization, 2nd ed., Springer 2006, algorithm 7.4.
class CurvatureBySteps {
 public:
  explicit CurvatureBySteps(const MatrixXd& expected) : expected_(expected) {}

  void add(const VectorXd& step, const VectorXd& change_of_gradient) {
    const double curvature = step.dot(change_of_gradient);
    if (curvature > 1e-12 * step.norm() * change_of_gradient.norm())
      pairs_.push_back({step, change_of_gradient, 1.0 / curvature});
  }
  VectorXd step(const VectorXd& gradient) const {
    VectorXd q = gradient;
    std::vector<double> alpha(pairs_.size());
    for (std::size_t k = pairs_.size(); k-- > 0;) {
      alpha[k] = pairs_[k].inverse_curvature * pairs_[k].step.dot(q);
      q -= alpha[k] * pairs_[k].change;
    }
    q = expected_.solve(q);
    for (std::size_t k = 0; k < pairs_.size(); ++k)
      q += (alpha[k] - pairs_[k].inverse_curvature * pairs_[k].change.dot(q)) * pairs_[k].step;
    return -q;
  }

 private:
  struct Pair {
    VectorXd step, change;
    double inverse_curvature;
  };
  Eigen::LDLT<MatrixXd> expected_;
  std::vector<Pair> pairs_;
};

}  // namespace

PosteriorMode posterior_mode(const CarPosterior& posterior, const VectorXd& start, double enough) {
  constexpr int kScoring = 6;  ///< steps by the information; those to come by what the steps show as well
  constexpr int kMostSteps = 60;
  constexpr double kRounding = 1e-11;  ///< of J, a sum of thousands that cancel
  PosteriorMode mode{.v = start, .covariance = {}};
  VectorXd gradient, before;
  mode.value = posterior.value(mode.v, gradient);
  if (!std::isfinite(mode.value)) return mode;
  std::optional<CurvatureBySteps> curvature;
  for (; mode.steps < kMostSteps && !mode.converged; ++mode.steps) {
    VectorXd step;
    if (mode.steps < kScoring) {
      MatrixXd information = posterior.information(mode.v);
      step = bounded_step(information, gradient);
      if (mode.steps == kScoring - 1) curvature.emplace(information);
    } else {
      step = curvature->step(gradient);
    }
    const double gain = -step.dot(gradient);
    if (!(gain > 0.0)) break;
    if (gain < std::max(enough, kRounding * std::abs(mode.value))) mode.converged = true;
    double part = 1.0;
    double value = posterior.value(mode.v + step);
    const double most = mode.value + 1e-9;
    while (!(value < most) && part > 1e-3) {
      part *= 0.5;
      value = posterior.value(mode.v + part * step);
    }
    if (!(value < most)) break;
    mode.v += part * step;
    before = gradient;
    mode.value = posterior.value(mode.v, gradient);
    if (curvature) curvature->add(part * step, gradient - before);
  }
  const MatrixXd information = posterior.information(mode.v);
  mode.converged = mode.converged && information.llt().info() == Eigen::Success;
  mode.covariance = information.inverse();
  return mode;
}

}  // namespace roadbalance
