#include "host/analysis/identify/estimators/relation_prediction.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "common/vehicle/contact_patch.hpp"
#include "common/vehicle/unbalance_response.hpp"
#include "host/analysis/identify/signals.hpp"

namespace roadbalance {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;
using Vector7c = Eigen::Matrix<Complex, kCoordinates, 1>;
using Matrix7c = Eigen::Matrix<Complex, kCoordinates, kCoordinates>;

// Body and wheels respond from 1 to 15 Hz; the acceleration of a wheel, filtered, falls as 1 / f^5 beyond the
// contact patch's 130 Hz.
constexpr double kLeast_hz = 0.05, kMost_hz = 3000.0;
constexpr double kStep = 0.025;  ///< of ln om; with a damping of 0.1 exp(-2 pi 0.1 / 0.025) = 1e-11
// A covariance of covariances only weighs: the band of the filters, in coarser steps.
constexpr std::size_t kScatterStep = 4;
constexpr double kScatterLeast_hz = 0.5, kScatterMost_hz = 150.0;
constexpr double kLeastRoad = 1e-3;  ///< of a wheel's level, part of the largest

struct Pair {
  int i, j;
};
/// Entries of b: diagonal first.
constexpr std::array<Pair, 10> kPairs{Pair{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 1},
                                      {2, 3},     {0, 2}, {1, 3}, {0, 3}, {1, 2}};

int signal_of(const RelationInstrument& instrument) {
  return instrument.row % kRelationSignals;
}
int state_of(const RelationInstrument& instrument) {
  return instrument.row / kRelationSignals;
}

}  // namespace

RelationPrediction::RelationPrediction(const PredictedCar& car, const RelationCovariances& measured,
                                       const RelationFilter::Options& filter, double road_exponent)
    : car_(car),
      options_(filter),
      filter_(butterworth(filter.order, filter.cutoff_hz)),
      H_(companion_annihilator(filter_)),
      exponent_(road_exponent),
      speed_m_s_(measured.speed_m_s()),
      seconds_(measured.seconds),
      omega_(measured.omega()) {
  if (measured.lag.size() != filter.lags_s.size())
    throw std::invalid_argument("covariances of " + std::to_string(measured.lag.size()) +
                                " lags, a filter of " + std::to_string(filter.lags_s.size()));
  if (measured.power.size() != H_.instruments() * kRelationSignals)
    throw std::invalid_argument("covariances of " + std::to_string(measured.power.size()) +
                                " instruments, a filter of order " + std::to_string(filter.order));
  for (double ln = std::log(2.0 * pi * kLeast_hz); ln < std::log(2.0 * pi * kMost_hz); ln += kStep) {
    const double om = std::exp(ln);
    const Matrix7c dynamic = car.model.Q.cast<Complex>() + kJ * om * car.model.P.cast<Complex>() -
                             (om * om * car.model.M).cast<Complex>();
    const Eigen::Matrix<Complex, kCoordinates, kWheels> input =
        car.model.S.cast<Complex>() + kJ * om * car.model.Sd.cast<Complex>();
    grid_.push_back({om, kStep * om / pi * road_shape(om), filter_at(om),
                     -om * om * dynamic.partialPivLu().solve(input)});
  }
  line_.setZero();
  line_filter_.resize(H_.instruments(), kWheels);
  line_filter_.setZero();
  for (int i = 0; i < kWheels; ++i) {
    if (!(omega_(i) > 0.0)) continue;
    line_.col(i) =
        unbalance_response(car.model, i, omega_(i)) * car.unbalance_kg_m[static_cast<std::size_t>(i)];
    line_filter_.col(i) = filter_at(omega_(i));
  }
  fit_roads(measured);
}

Eigen::VectorXcd RelationPrediction::filter_at(double omega) const {
  const Eigen::Index order = filter_.G.size();
  const Eigen::MatrixXcd resolvent =
      kJ * omega * Eigen::MatrixXcd::Identity(order, order) - filter_.F.cast<Complex>();
  return H_.w2.cast<Complex>() * resolvent.partialPivLu().solve(filter_.G.cast<Complex>());
}

double RelationPrediction::road_shape(double omega) const {
  return std::pow(omega, -exponent_) / (1.0 + std::pow(omega / (2.0 * pi * kPatchWave_1_m * speed_m_s_), 2));
}

Eigen::Vector4cd RelationPrediction::advance(double omega) const {
  Eigen::Vector4cd e;
  for (int i = 0; i < kWheels; ++i)
    e(i) = std::polar(1.0, omega * car_.geometry.x_m[static_cast<std::size_t>(i)] / speed_m_s_);
  return e;
}

Complex RelationPrediction::tyre(int wheel, double omega) const {
  const int row = kBodyCoordinates + wheel;
  return {car_.model.S(row, wheel), omega * car_.model.Sd(row, wheel)};
}

void RelationPrediction::fit_roads(const RelationCovariances& measured) {
  constexpr int kBlock = kCoordinates * kCoordinates;
  const Eigen::Index states = H_.instruments();
  const auto lags = static_cast<Eigen::Index>(options_.lags_s.size());
  // [of lag, state, coordinate after, coordinate filtered; pair of wheels]
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(lags * states * kBlock, kPairs.size());
  Eigen::MatrixXd filtered_power = Eigen::MatrixXd::Zero(states, kCoordinates);
  Vector7 power = Vector7::Zero();
  for (const Frequency& f : grid_) {
    const Eigen::Vector4cd e = advance(f.omega);
    for (std::size_t p = 0; p < kPairs.size(); ++p) {
      const auto [i, j] = kPairs[p];
      const auto spectrum = [&](int a, int b) -> Matrix7c {
        return f.G.col(a).conjugate() * (std::conj(e(a)) * e(b)) * f.G.col(b).transpose();
      };
      const Matrix7c P = i == j ? spectrum(i, i) : Matrix7c(spectrum(i, j) + spectrum(j, i));
      for (Eigen::Index l = 0; l < lags; ++l)
        for (Eigen::Index k = 0; k < states; ++k) {
          const Complex h = f.weight * std::conj(f.filter(k)) *
                            std::polar(1.0, f.omega * options_.lags_s[static_cast<std::size_t>(l)]);
          expected.block<kBlock, 1>((l * states + k) * kBlock, static_cast<Eigen::Index>(p)) +=
              (h * P).real().reshaped();
        }
    }
    const Vector7 own = f.weight * f.G.rowwise().squaredNorm();
    power += own;
    filtered_power += f.filter.cwiseAbs2() * own.transpose();
  }
  Eigen::VectorXd random(expected.rows());
  Eigen::VectorXd size(expected.rows());
  for (Eigen::Index l = 0; l < lags; ++l)
    for (Eigen::Index k = 0; k < states; ++k) {
      const auto lag = static_cast<std::size_t>(l);
      Matrix7 C = measured.lag[lag].w2_z.middleRows<kCoordinates>(k * kRelationSignals) / measured.seconds;
      for (int i = 0; i < kWheels; ++i)
        C -= 0.5 * (std::conj(line_filter_(k, i)) * std::polar(1.0, omega_(i) * options_.lags_s[lag]) *
                    line_.col(i).conjugate() * line_.col(i).transpose())
                       .real();
      const Eigen::Index at = (l * states + k) * kBlock;
      random.segment<kBlock>(at) = C.reshaped();
      size.segment<kBlock>(at) =
          (filtered_power.row(k).transpose().cwiseSqrt() * power.cwiseSqrt().transpose()).reshaped();
    }
  const auto scale = size.cwiseInverse().asDiagonal();
  const Eigen::VectorXd b = (scale * expected).colPivHouseholderQr().solve(scale * random);
  for (std::size_t p = 0; p < kPairs.size(); ++p)
    roads_(kPairs[p].i, kPairs[p].j) = roads_(kPairs[p].j, kPairs[p].i) = b(static_cast<Eigen::Index>(p));
  // Of a short drive they may come out as no covariance of anything.
  const double least = kLeastRoad * roads_.diagonal().cwiseAbs().maxCoeff();
  roads_.diagonal() = roads_.diagonal().cwiseMax(least);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(roads_);
  root_ = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  roads_ = root_ * root_.transpose();
}

Eigen::RowVector4cd RelationPrediction::phasors(const RelationInstrument& instrument) const {
  const int signal = signal_of(instrument);
  Eigen::RowVector4cd A = Eigen::RowVector4cd::Zero();
  for (int i = 0; i < kWheels; ++i) {
    // cos alpha = Re{e^{j alpha}}, sin alpha = Re{-j e^{j alpha}}.
    const Complex input = signal < kCoordinates     ? line_(signal, i)
                          : signal == cosine_row(i) ? Complex(1.0)
                          : signal == sine_row(i)   ? -kJ
                                                    : Complex(0.0);
    A(i) = line_filter_(state_of(instrument), i) * input *
           std::polar(1.0, -omega_(i) * options_.lags_s[instrument.lag]);
  }
  return A;
}

Eigen::VectorXd RelationPrediction::road(int wheel,
                                         const std::vector<RelationInstrument>& instruments) const {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(instruments.size()));
  for (const Frequency& f : grid_) {
    const Eigen::Vector4cd e = advance(f.omega);
    const Eigen::Vector4cd S = e.conjugate().cwiseProduct(roads_.col(wheel).cast<Complex>()) * e(wheel);
    const Vector7c with_force = f.weight * tyre(wheel, f.omega) * (f.G.conjugate() * S);
    std::vector<Complex> later;
    for (const double lag_s : options_.lags_s) later.push_back(std::polar(1.0, f.omega * lag_s));
    for (std::size_t a = 0; a < instruments.size(); ++a)
      if (const int signal = signal_of(instruments[a]); signal < kCoordinates)
        mean(static_cast<Eigen::Index>(a)) +=
            (std::conj(f.filter(state_of(instruments[a]))) * later[instruments[a].lag] * with_force(signal))
                .real();
  }
  return mean;
}

Eigen::MatrixXd RelationPrediction::scatter(int wheel,
                                            const std::vector<RelationInstrument>& instruments) const {
  const auto n = static_cast<Eigen::Index>(instruments.size());
  std::vector<const Frequency*> coarse;
  for (std::size_t k = 0; k < grid_.size(); k += kScatterStep)
    if (const double f = grid_[k].omega / (2.0 * pi); f > kScatterLeast_hz && f < kScatterMost_hz)
      coarse.push_back(&grid_[k]);
  const auto frequencies = static_cast<Eigen::Index>(coarse.size());
  // V = Re{X X^H} + Re{Y Y^T}, a column of X for each frequency and input, of Y for each frequency.
  Eigen::MatrixXcd X = Eigen::MatrixXcd::Zero(n, kWheels * (frequencies + 1));
  Eigen::MatrixXcd Y = Eigen::MatrixXcd::Zero(n, frequencies);
  for (Eigen::Index k = 0; k < frequencies; ++k) {
    const Frequency& f = *coarse[static_cast<std::size_t>(k)];
    const double shape = road_shape(f.omega);
    const double weight = static_cast<double>(kScatterStep) * f.weight / shape;
    const Eigen::Matrix4cd roads = std::sqrt(shape) * advance(f.omega).conjugate().asDiagonal() * root_;
    const Eigen::Matrix<Complex, kCoordinates, kWheels> z = f.G.conjugate() * roads;
    const Eigen::RowVector4cd force = std::conj(tyre(wheel, f.omega)) * roads.row(wheel);
    for (Eigen::Index a = 0; a < n; ++a) {
      const RelationInstrument& instrument = instruments[static_cast<std::size_t>(a)];
      const int signal = signal_of(instrument);
      if (signal >= kCoordinates) continue;
      const Eigen::RowVector4cd w = std::conj(f.filter(state_of(instrument))) *
                                    std::polar(1.0, f.omega * options_.lags_s[instrument.lag]) *
                                    z.row(signal);
      X.block<1, kWheels>(a, kWheels * k) = std::sqrt(weight) * force.norm() * w;
      Y(a, k) = std::sqrt(weight) * (w * force.adjoint()).value();
    }
  }
  for (Eigen::Index a = 0; a < n; ++a)
    X.row(a).tail<kWheels>() = phasors(instruments[static_cast<std::size_t>(a)]).conjugate();
  for (int i = 0; i < kWheels; ++i)
    if (omega_(i) > 0.0)
      X.col(kWheels * frequencies + i) *=
          std::abs(tyre(wheel, omega_(i))) * std::sqrt(0.5 * roads_(wheel, wheel) * road_shape(omega_(i)));
  const Eigen::MatrixXd Xr = X.real(), Xi = X.imag(), Yr = Y.real(), Yi = Y.imag();
  return (Xr * Xr.transpose() + Xi * Xi.transpose() + Yr * Yr.transpose() - Yi * Yi.transpose()) / seconds_;
}

Eigen::MatrixXd RelationPrediction::harmonic(int wheel,
                                             const std::vector<RelationInstrument>& instruments) const {
  Eigen::Matrix<Complex, kWheels, 3> force = Eigen::Matrix<Complex, kWheels, 3>::Zero();
  for (int i = 0; i < kWheels; ++i)
    if (omega_(i) > 0.0) force(i, 0) = -line_(kBodyCoordinates + wheel, i) / (omega_(i) * omega_(i));
  const double om2 = omega_(wheel) * omega_(wheel);
  force(wheel, 1) = -om2;
  force(wheel, 2) = -kJ * om2;
  Eigen::MatrixXd mean(static_cast<Eigen::Index>(instruments.size()), 3);
  for (std::size_t a = 0; a < instruments.size(); ++a)
    mean.row(static_cast<Eigen::Index>(a)) = 0.5 * (phasors(instruments[a]).conjugate() * force).real();
  return mean;
}

}  // namespace roadbalance
