#include "host/analysis/identify/car_posterior.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "common/vehicle/contact_patch.hpp"
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
constexpr double kBodyTo_hz = 20.0;  ///< above it the body is not rigid
constexpr double kBand_hz = 4.0;     ///< of one level of the body's residuals
constexpr int kSides = 2;
constexpr int kKnots = 9;
constexpr int kShape = kKnots - 1;  ///< unknowns of a side: the exponent, and each inner knot
constexpr double kFirstKnot_1_m = 0.075, kLastKnot_1_m = 1.6;
constexpr double kReference_1_m = 0.6;  ///< where exponent and level are independent
constexpr int kRows = 2 * kWheels;      ///< of a road: forces, and heights, of the four wheels

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

/// Velocity and displacement per acceleration at a circular frequency, a block of channels each.
MatrixXcd integrals(Index channels, double omega) {
  MatrixXcd all = MatrixXcd::Zero(3 * channels, channels);
  const auto unit = MatrixXcd::Identity(channels, channels);
  all.topRows(channels) = unit;
  all.middleRows(channels, channels) = unit / (kJ * omega);
  all.bottomRows(channels) = -unit / (omega * omega);
  return all;
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
struct CarPosterior::Bins {
  MatrixXcd integral;         ///< [3 channels x channels]
  MatrixXcd residual;         ///< R
  MatrixXcd force;            ///< [4 x channels]
  Eigen::Vector4cd softness;  ///< 1 / c
  MatrixXcd road_inverse;     ///< [U; R]^-1
  MatrixXcd weight;           ///< (R R^H)^-1
  double log_determinant;     ///< log det R R^H - 2 log |det [U; R]|

  Bins(const Equations& of, Index residuals, Index channels, double omega)
      : integral(integrals(channels, omega)) {
    residual = rows_of(of.rows.topRows(residuals), integral);
    force = rows_of(of.rows.middleRows(residuals, kWheels), integral);
    for (Index i = 0; i < kWheels; ++i) softness(i) = 1.0 / of.tyre_at(i, omega);
    MatrixXcd all(channels, channels);
    all.topRows(kWheels) = softness.asDiagonal() * force + rows_of(of.rows.bottomRows(kWheels), integral);
    all.bottomRows(residuals) = residual;
    const Eigen::PartialPivLU<MatrixXcd> lu(all);
    road_inverse = lu.inverse();
    const Eigen::LLT<MatrixXcd> llt(residual * residual.adjoint());
    weight = llt.solve(MatrixXcd::Identity(residuals, residuals));
    log_determinant = 2.0 * MatrixXcd(llt.matrixL()).diagonal().real().array().log().sum() -
                      2.0 * lu.matrixLU().diagonal().array().abs().log().sum();
  }
};

CarPosterior::CarPosterior(const CarPrior& prior, std::vector<const SpectralMoments*> speeds)
    : prior_(prior),
      speeds_(std::move(speeds)),
      channels_(prior.sensors.rows()),
      bins_(speeds_.front()->bins()),
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
  size_ = known_ + kSides * kShape;
  const Eigen::JacobiSVD<MatrixXd> svd(prior.sensors, Eigen::ComputeFullU | Eigen::ComputeFullV);
  coordinates_ = svd.solve(MatrixXd::Identity(channels_, channels_));
  rigid_ = svd.matrixU().rightCols(channels_ - kCoordinates).transpose();
  scale_ << prior.value(kBodyMass), prior.value(kRollInertia), prior.value(kPitchInertia);
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
  Equations of{MatrixXd::Zero(residuals_ + kRows, 3 * channels_), parameters.segment<kWheels>(kTyre),
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
  of.rows.bottomRightCorner(kWheels, channels_) = coordinates.bottomRows(kWheels);
  return of;
}

/// Derivative of Equations::rows by an unknown of car or sensors.
MatrixXd CarPosterior::equations_by(const VectorXd& v, const Equations& of, Index unknown) const {
  MatrixXd rows = MatrixXd::Zero(of.rows.rows(), of.rows.cols());
  if (unknown >= std::ssize(parameter_)) {
    const Index c = channel_[static_cast<std::size_t>(unknown - std::ssize(parameter_))];
    for (int k = 0; k < 3; ++k)
      rows.col(k * channels_ + c) = -prior_.gain_sigma(c) * of.rows.col(k * channels_ + c);
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
  return rows;
}

/// By each unknown of a side's shape [bin].
std::vector<Eigen::ArrayXd> CarPosterior::log_shape_by(const SpectralMoments& speed) const {
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

/// [bin x side]
MatrixXd CarPosterior::log_shape(const VectorXd& v, const SpectralMoments& speed) const {
  const std::vector<Eigen::ArrayXd> by = log_shape_by(speed);
  const double speed_m_s = (prior_.geometry.x_m[0] - prior_.geometry.x_m[2]) / speed.delay_s();
  MatrixXd shape(bins_, kSides);
  for (Index k = 0; k < bins_; ++k) {
    const double n = omega(k) / (2.0 * std::numbers::pi * speed_m_s);
    shape.row(k).setConstant(-2.0 * std::log(n / kReference_1_m) -
                             std::log1p(std::pow(n / kPatchWave_1_m, 2)));
  }
  for (int side = 0; side < kSides; ++side)
    for (int b = 0; b < kShape; ++b)
      shape.col(side).array() += v(known_ + side * kShape + b) * by[static_cast<std::size_t>(b)];
  return shape;
}

double CarPosterior::prior_value(const VectorXd& v, VectorXd* gradient) const {
  double value = 0.5 * v.head(known_).squaredNorm();
  if (gradient) gradient->head(known_) += v.head(known_);
  static const MatrixXd kDifferences = second_differences();
  for (int side = 0; side < kSides; ++side) {
    const Index at = known_ + side * kShape;
    const VectorXd bent = kDifferences * v.segment(at + 1, kShape - 1);
    value += 0.5 * v(at) * v(at) + 0.5 * bent.squaredNorm();
    if (!gradient) continue;
    (*gradient)(at) += v(at);
    gradient->segment(at + 1, kShape - 1) += kDifferences.transpose() * bent;
  }
  return value;
}

double CarPosterior::value(const VectorXd& v) const {
  return evaluate(v, nullptr);
}

double CarPosterior::value(const VectorXd& v, VectorXd& gradient) const {
  return evaluate(v, &gradient);
}

double CarPosterior::evaluate(const VectorXd& v, VectorXd* gradient) const {
  const Equations of = equations(v);
  if (!of.rows.allFinite() || (of.tyre.array() <= 0.0).any()) return std::numeric_limits<double>::infinity();
  const MatrixXd residual_rows = of.rows.topRows(residuals_);
  const MatrixXd road_rows = of.rows.bottomRows(kRows);
  // Rows of the front wheels' forces and heights, and of the rear ones'.
  MatrixXd front_rows(kWheels, 3 * channels_), rear_rows(kWheels, 3 * channels_);
  front_rows << road_rows.topRows(2), road_rows.middleRows(kWheels, 2);
  rear_rows << road_rows.middleRows(2, 2), road_rows.bottomRows(2);

  std::vector<Bins> bin;
  bin.reserve(static_cast<std::size_t>(bins_));
  for (Index k = 0; k < bins_; ++k) bin.emplace_back(of, residuals_, channels_, omega(k));

  // By the rows of the equations, as half of the gradient: dJ = 2 tr(d rows * by_rows).
  MatrixXd by_residual = MatrixXd::Zero(3 * channels_, residuals_),
           by_road = MatrixXd::Zero(3 * channels_, kRows);
  MatrixXcd by_softness = MatrixXcd::Zero(bins_, kWheels);  // dJ = Re sum by_softness d(1 / c)
  if (gradient) gradient->setZero(size_);

  double value = 0.0;
  // The body: its residuals of all speeds.
  Eigen::ArrayXd power = Eigen::ArrayXd::Zero(bins_), count = power;
  std::vector<MatrixXcd> same(static_cast<std::size_t>(bins_), MatrixXcd::Zero(3 * channels_, 3 * channels_));
  for (Index k = 0; k < bins_; ++k) {
    for (const SpectralMoments* speed : speeds_) {
      count(k) += speed->count(k);
      if (is_of_body(k)) same[static_cast<std::size_t>(k)] += speed->same[static_cast<std::size_t>(k)];
    }
    if (!is_of_body(k)) continue;
    const MatrixXcd all = sandwich(residual_rows, same[static_cast<std::size_t>(k)], residual_rows);
    power(k) = (bin[static_cast<std::size_t>(k)].weight * all).trace().real();
  }
  for (double low_hz = 0.0; low_hz < kBodyTo_hz; low_hz += kBand_hz) {
    double band_power = 0.0, band_count = 0.0;
    std::vector<Index> in_band;
    for (Index k = 0; k < bins_; ++k) {
      const double frequency_hz = omega(k) / (2.0 * std::numbers::pi);
      if (!is_of_body(k) || frequency_hz <= low_hz + 1e-9 || frequency_hz > low_hz + kBand_hz + 1e-9)
        continue;
      in_band.push_back(k);
      band_power += power(k);
      band_count += static_cast<double>(residuals_) * count(k);
    }
    if (band_count <= 0.0) continue;
    const double level = std::max(band_power / band_count, prior_.noise_m2_s4_hz);
    value += band_count * std::log(level) + band_power / level;
    if (!gradient) continue;
    for (const Index k : in_band) {
      const Bins& b = bin[static_cast<std::size_t>(k)];
      const MatrixXcd& x = same[static_cast<std::size_t>(k)];
      const MatrixXcd all = sandwich(residual_rows, x, residual_rows);
      by_residual +=
          (onto(x, residual_rows) * b.weight - b.integral * b.residual.adjoint() * b.weight * all * b.weight)
              .real() /
          level;
    }
  }

  // The road.
  for (const SpectralMoments* speed : speeds_) {
    const MatrixXd shape = log_shape(v, *speed);
    std::vector<Eigen::Matrix4cd> road(static_cast<std::size_t>(bins_));
    Eigen::Matrix4d level = Eigen::Matrix4d::Zero();
    double all_count = 0.0;
    const auto by_shape = [&](Index k) {
      const double left = std::exp(-0.5 * shape(k, 0)), right = std::exp(-0.5 * shape(k, 1));
      return Eigen::Vector4d(left, right, left, right);
    };
    // u = K rows x, K = [diag(1 / c), 1]
    const auto to_road = [&](Index k) {
      Eigen::Matrix<Complex, kWheels, kRows> map;
      map << Eigen::Matrix4cd(bin[static_cast<std::size_t>(k)].softness.asDiagonal()),
          Eigen::Matrix4cd::Identity();
      return map;
    };
    const auto to_axle = [&](Index k, int first) {
      Eigen::Matrix<Complex, 2, kWheels> map;
      map << Eigen::Matrix2cd(bin[static_cast<std::size_t>(k)].softness.segment<2>(first).asDiagonal()),
          Eigen::Matrix2cd::Identity();
      return map;
    };
    for (Index k = 0; k < bins_; ++k) {
      if (!is_of_road(k) || speed->count(k) <= 0.0) continue;
      const auto b = static_cast<std::size_t>(k);
      const auto map = to_road(k);
      const MatrixXcd rows = sandwich(road_rows, speed->same[b], road_rows);
      Eigen::Matrix4cd u = map * rows * map.adjoint();
      const MatrixXcd between = sandwich(front_rows, speed->delayed[b], rear_rows);
      u.topRightCorner<2, 2>() = to_axle(k, 0) * between * to_axle(k, 2).adjoint();
      u.bottomLeftCorner<2, 2>() = u.topRightCorner<2, 2>().adjoint().eval();
      road[b] = u;
      const Eigen::Vector4d scale = by_shape(k);
      level += scale.asDiagonal() * u.real() * scale.asDiagonal();
      all_count += speed->count(k);
      value += speed->count(k) * (2.0 * shape.row(k).sum() + bin[b].log_determinant);
    }
    if (all_count <= 0.0) continue;
    level /= all_count;
    const Eigen::LLT<Eigen::Matrix4d> llt(level);
    if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    value += 2.0 * all_count * Eigen::Matrix4d(llt.matrixL()).diagonal().array().log().sum();
    if (!gradient) continue;

    const Eigen::Matrix4d inverse = llt.solve(Eigen::Matrix4d::Identity());
    MatrixXd by_log_shape = MatrixXd::Zero(bins_, kSides);
    for (Index k = 0; k < bins_; ++k) {
      if (!is_of_road(k) || speed->count(k) <= 0.0) continue;
      const auto b = static_cast<std::size_t>(k);
      const double n = speed->count(k);
      const Eigen::Vector4d scale = by_shape(k);
      const Eigen::Matrix4d weight = scale.asDiagonal() * inverse * scale.asDiagonal();
      Eigen::Matrix4d on_axle = weight;
      on_axle.topRightCorner<2, 2>().setZero();
      on_axle.bottomLeftCorner<2, 2>().setZero();
      const Eigen::Matrix2d across = weight.topRightCorner<2, 2>();
      const auto map = to_road(k);
      const auto map_front = to_axle(k, 0), map_rear = to_axle(k, 2);

      const MatrixXcd half = onto(speed->same[b], road_rows);
      const MatrixXcd on_map = map.adjoint() * on_axle;
      by_road += (half * on_map * map).real();
      const MatrixXcd rows_on = rows_of(road_rows, half) * on_map;  // [8 x 4]
      const Eigen::Matrix4cd back = map_rear.adjoint() * across.transpose() * map_front;
      const MatrixXcd by_front = onto(speed->delayed[b], rear_rows) * back;
      const MatrixXcd by_rear = (back * rows_of(front_rows, speed->delayed[b])).transpose();
      by_road.leftCols(2) += by_front.leftCols(2).real();
      by_road.middleCols(kWheels, 2) += by_front.rightCols(2).real();
      by_road.middleCols(2, 2) += by_rear.leftCols(2).real();
      by_road.rightCols(2) += by_rear.rightCols(2).real();
      const MatrixXcd between = sandwich(front_rows, speed->delayed[b], rear_rows);
      const MatrixXcd front_on = between * map_rear.adjoint() * across.transpose();  // [4 x 2]
      const MatrixXcd rear_on = across.transpose() * map_front * between;            // [2 x 4]
      const Bins& of_bin = bin[b];
      const MatrixXcd inverse_road = of_bin.road_inverse.leftCols(kWheels);
      for (Index i = 0; i < kWheels; ++i) {
        by_softness(k, i) += 2.0 * rows_on(i, i);
        by_softness(k, i) += 2.0 * (i < 2 ? front_on(i, i) : std::conj(rear_on(i - 2, i - 2)));
        by_softness(k, i) -= 2.0 * n * (of_bin.force.row(i) * inverse_road.col(i)).value();
      }
      // log det R R^H - 2 log |det [U; R]|
      by_residual += n * (of_bin.integral * (of_bin.residual.adjoint() * of_bin.weight -
                                             of_bin.road_inverse.rightCols(residuals_)))
                             .real();
      const MatrixXcd by_height = of_bin.integral * inverse_road;
      by_road.leftCols(kWheels) -= n * (by_height * of_bin.softness.asDiagonal()).real();
      by_road.rightCols(kWheels) -= n * by_height.real();
      const Eigen::Matrix4d share = weight.cwiseProduct(road[b].real());
      for (int side = 0; side < kSides; ++side)
        by_log_shape(k, side) = 2.0 * n - share.row(side).sum() - share.row(side + 2).sum();
    }
    const std::vector<Eigen::ArrayXd> by = log_shape_by(*speed);
    for (int side = 0; side < kSides; ++side)
      for (int s = 0; s < kShape; ++s)
        (*gradient)(known_ + side * kShape + s) +=
            (by_log_shape.col(side).array() * by[static_cast<std::size_t>(s)]).sum();
  }

  if (gradient) {
    MatrixXd by_rows(3 * channels_, residuals_ + kRows);
    by_rows << by_residual, by_road;
    for (Index a = 0; a < known_; ++a)
      (*gradient)(a) += 2.0 * equations_by(v, of, a).transpose().cwiseProduct(by_rows).sum();
    for (std::size_t a = 0; a < parameter_.size(); ++a) {
      const int p = parameter_[a];
      if (p < kTyre) continue;
      const Index wheel = (p - kTyre) % kWheels;
      const double step = is_tyre_damper(p) ? prior_.sigma(p) : prior_.sigma(p) * of.tyre(wheel);
      for (Index k = 0; k < bins_; ++k) {
        const Complex softness = bin[static_cast<std::size_t>(k)].softness(wheel);
        const Complex by_stiffness = is_tyre_damper(p) ? kJ * omega(k) : Complex(1.0);
        (*gradient)(static_cast<Index>(a)) +=
            (by_softness(k, wheel) * -softness * softness * by_stiffness * step).real();
      }
    }
  }
  return value + prior_value(v, gradient);
}

MatrixXd CarPosterior::information(const VectorXd& v) const {
  const Equations of = equations(v);
  MatrixXd information = MatrixXd::Zero(size_, size_);
  std::vector<MatrixXd> rows_by;
  for (Index a = 0; a < known_; ++a) rows_by.push_back(equations_by(v, of, a));

  // How residuals and road change by each unknown, per unit of the road [unknown][bin].
  std::vector<std::vector<MatrixXcd>> residual_by(static_cast<std::size_t>(known_)), road_by = residual_by;
  std::vector<Bins> bin;
  for (Index k = 0; k < bins_; ++k) {
    const Bins& b = bin.emplace_back(of, residuals_, channels_, omega(k));
    const MatrixXcd from_road = b.integral * b.road_inverse.leftCols(kWheels);
    for (Index a = 0; a < known_; ++a) {
      const MatrixXd& rows = rows_by[static_cast<std::size_t>(a)];
      residual_by[static_cast<std::size_t>(a)].push_back(rows_of(rows.topRows(residuals_), from_road));
      MatrixXcd road = b.softness.asDiagonal() * rows_of(rows.middleRows(residuals_, kWheels), from_road) +
                       rows_of(rows.bottomRows(kWheels), from_road);
      if (a < std::ssize(parameter_) && parameter_[static_cast<std::size_t>(a)] >= kTyre) {
        const int p = parameter_[static_cast<std::size_t>(a)];
        const Index wheel = (p - kTyre) % kWheels;
        const Complex step =
            is_tyre_damper(p) ? kJ * omega(k) * prior_.sigma(p) : Complex(prior_.sigma(p) * of.tyre(wheel));
        road.row(wheel) -= b.softness(wheel) * b.softness(wheel) * step *
                           (b.force.row(wheel) * b.road_inverse.leftCols(kWheels));
      }
      road_by[static_cast<std::size_t>(a)].push_back(road);
    }
  }

  // The body, by the road alone.
  const MatrixXd residual_rows = of.rows.topRows(residuals_), road_rows = of.rows.bottomRows(kRows);
  std::vector<Eigen::Matrix4cd> all_roads(static_cast<std::size_t>(bins_), Eigen::Matrix4cd::Zero());
  Eigen::ArrayXd power = Eigen::ArrayXd::Zero(bins_), count = power;
  for (Index k = 0; k < bins_; ++k) {
    const auto b = static_cast<std::size_t>(k);
    Eigen::Matrix<Complex, kWheels, kRows> map;
    map << Eigen::Matrix4cd(bin[b].softness.asDiagonal()), Eigen::Matrix4cd::Identity();
    for (const SpectralMoments* speed : speeds_) {
      count(k) += speed->count(k);
      const MatrixXcd rows = sandwich(road_rows, speed->same[b], road_rows);
      all_roads[b] += map * rows * map.adjoint();
      power(k) += (bin[b].weight * sandwich(residual_rows, speed->same[b], residual_rows)).trace().real();
    }
  }
  for (double low_hz = 0.0; low_hz < kBodyTo_hz; low_hz += kBand_hz) {
    double band_power = 0.0, band_count = 0.0;
    std::vector<Index> in_band;
    for (Index k = 0; k < bins_; ++k) {
      const double frequency_hz = omega(k) / (2.0 * std::numbers::pi);
      if (!is_of_body(k) || frequency_hz <= low_hz + 1e-9 || frequency_hz > low_hz + kBand_hz + 1e-9)
        continue;
      in_band.push_back(k);
      band_power += power(k);
      band_count += static_cast<double>(residuals_) * count(k);
    }
    if (band_count <= 0.0) continue;
    const double level = std::max(band_power / band_count, prior_.noise_m2_s4_hz);
    for (const Index k : in_band) {
      const auto b = static_cast<std::size_t>(k);
      for (Index a = 0; a < known_; ++a) {
        const MatrixXcd weighed =
            bin[b].weight * residual_by[static_cast<std::size_t>(a)][b] * all_roads[b] / level;
        for (Index c = 0; c <= a; ++c)
          information(a, c) +=
              2.0 *
              weighed.conjugate().cwiseProduct(residual_by[static_cast<std::size_t>(c)][b]).sum().real();
      }
    }
  }

  // The road, of each speed: Gaussian with E[u u^H] = phi L; what could as well be a change of L is taken
  // off.
  for (const SpectralMoments* speed : speeds_) {
    const MatrixXd shape = log_shape(v, *speed);
    const std::vector<Eigen::ArrayXd> by = log_shape_by(*speed);
    std::vector<Index> used;
    Eigen::Matrix4d level = Eigen::Matrix4d::Zero();
    double all_count = 0.0;
    for (Index k = 0; k < bins_; ++k)
      if (is_of_road(k) && speed->count(k) > 0.0) used.push_back(k);
    std::vector<Eigen::Vector4cd> scale;
    for (const Index k : used) {
      const auto b = static_cast<std::size_t>(k);
      const double left = std::exp(-0.5 * shape(k, 0)), right = std::exp(-0.5 * shape(k, 1));
      const Complex advance = std::polar(1.0, omega(k) * speed->delay_s());
      scale.emplace_back(left, right, left * advance, right * advance);
      Eigen::Matrix<Complex, kWheels, kRows> map;
      map << Eigen::Matrix4cd(bin[b].softness.asDiagonal()), Eigen::Matrix4cd::Identity();
      const MatrixXcd rows = sandwich(road_rows, speed->same[b], road_rows);
      const MatrixXcd delayed = sandwich(road_rows, speed->delayed[b], road_rows);
      Eigen::Matrix4cd u = map * rows * map.adjoint();
      u.topRightCorner<2, 2>() = (map * delayed * map.adjoint()).topRightCorner<2, 2>();
      u.bottomLeftCorner<2, 2>() = u.topRightCorner<2, 2>().adjoint().eval();
      const Eigen::Vector4d size = scale.back().cwiseAbs();
      level += size.asDiagonal() * u.real() * size.asDiagonal();
      all_count += speed->count(k);
    }
    if (all_count <= 0.0) continue;
    level /= all_count;
    const Eigen::LLT<Eigen::Matrix4d> llt(level);
    const Eigen::Matrix4d lower = llt.matrixL();
    const Eigen::Matrix4d upward = lower.inverse();
    // Real rows of L^-1/2 S L^-T/2, so that their products are traces.
    const Index each = 32, columns = each * std::ssize(used);
    MatrixXd signal(size_, columns), means = MatrixXd::Zero(size_, 16);
    for (std::size_t at = 0; at < used.size(); ++at) {
      const Index k = used[at];
      const double weight = speed->count(k);
      const auto put = [&](Index unknown, const Eigen::Matrix4cd& change) {
        const Eigen::Matrix4cd moved = change * level;
        const Eigen::Matrix4cd white = upward * (moved + moved.adjoint()) * upward.transpose();
        const Eigen::Matrix4d real = white.real(), imaginary = white.imag();
        auto row = signal.row(unknown).segment(each * static_cast<Index>(at), each);
        row.head<16>() = std::sqrt(weight) * real.reshaped().transpose();
        row.tail<16>() = std::sqrt(weight) * imaginary.reshaped().transpose();
        means.row(unknown) += weight * real.reshaped().transpose();
      };
      const Eigen::Vector4cd& s = scale[at];
      for (Index a = 0; a < known_; ++a)
        put(a, s.asDiagonal() * road_by[static_cast<std::size_t>(a)][static_cast<std::size_t>(k)] *
                   s.cwiseInverse().asDiagonal());
      for (int side = 0; side < kSides; ++side)
        for (int b = 0; b < kShape; ++b) {
          Eigen::Vector4cd of_side = Eigen::Vector4cd::Zero();
          of_side(side) = of_side(side + 2) = -0.5 * by[static_cast<std::size_t>(b)](k);
          put(known_ + side * kShape + b, of_side.asDiagonal());
        }
    }
    information.triangularView<Eigen::Lower>() +=
        signal * signal.transpose() - means * means.transpose() / all_count;
  }

  information.diagonal().head(known_).array() += 1.0;
  static const MatrixXd kDifferences = second_differences();
  for (int side = 0; side < kSides; ++side) {
    const Index at = known_ + side * kShape;
    information(at, at) += 1.0;
    information.block(at + 1, at + 1, kShape - 1, kShape - 1) += kDifferences.transpose() * kDifferences;
  }
  return information.selfadjointView<Eigen::Lower>();
}

PosteriorMode posterior_mode(const CarPosterior& posterior, const VectorXd& start) {
  constexpr int kMostSteps = 30;
  constexpr double kEnough = 1e-3;  ///< of J: a step that gains less is a thirtieth of a standard deviation
  PosteriorMode mode{.v = start, .covariance = {}};
  VectorXd gradient;
  mode.value = posterior.value(mode.v, gradient);
  for (; mode.steps < kMostSteps && !mode.converged; ++mode.steps) {
    const Eigen::LDLT<MatrixXd> information(posterior.information(mode.v));
    const VectorXd step = -information.solve(gradient);
    const double gain = -step.dot(gradient);
    if (!(gain > 0.0)) break;
    if (gain < kEnough) mode.converged = true;
    double part = 1.0;
    VectorXd next = mode.v + step;
    double value = posterior.value(next);
    while (!(value < mode.value + 1e-9) && part > 1e-3) {
      part *= 0.5;
      next = mode.v + part * step;
      value = posterior.value(next);
    }
    if (!(value < mode.value + 1e-9)) break;
    mode.v = next;
    mode.value = posterior.value(next, gradient);
  }
  mode.covariance = posterior.information(mode.v).inverse();
  return mode;
}

}  // namespace roadbalance
