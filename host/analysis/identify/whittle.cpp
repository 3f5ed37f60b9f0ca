#include "host/analysis/identify/whittle.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "common/vehicle/contact_patch.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using Matrix7c = Eigen::Matrix<Complex, kCoordinates, kCoordinates>;
using Matrix8c = Eigen::Matrix<Complex, 2 * kWheels, 2 * kWheels>;
constexpr double kPatchCorner_rad_m = 2.0 * std::numbers::pi * kPatchWave_1_m;
constexpr double kSearch = 0.3;      ///< a stiffness is looked for within this share of the beginning
constexpr double kConverged = 1e-4;  ///< of a standard deviation
constexpr int kIterations = 30;
/// theta: stiffnesses of the four tyres over those of the beginning, then the exponent.
constexpr int kExponent = kWheels;
constexpr int kSearched = kWheels + 1;
using Theta = Eigen::Matrix<double, kSearched, 1>;
using Information = Eigen::Matrix<double, kSearched, kSearched>;

/// One bin at one speed.
struct Bin {
  double omega;
  double count;
  double patch;              ///< phi om^w
  Eigen::Vector4cd advance;  ///< v = advance u
  Eigen::Matrix4cd K0;       ///< force on the wheels per z of the wheels: no tyres, body free
  Matrix8c J;                ///< sum of [z; F][z; F]^H, rear wheels advanced
};
using Speeds = std::vector<std::vector<Bin>>;

/// D without tyres, its body eliminated: |D| / |D_cc| = |K0 + diag(c)|.
Eigen::Matrix4cd wheel_stiffness(const LinearModel& model, double omega) {
  const Matrix7c D = model.Q.cast<Complex>() + kJ * omega * model.P.cast<Complex>() -
                     (omega * omega * model.M).cast<Complex>();
  constexpr int kBody = kBodyCoordinates;
  const Eigen::Matrix3cd D_cc = D.topLeftCorner<kBody, kBody>();
  return D.bottomRightCorner<kWheels, kWheels>() -
         D.bottomLeftCorner<kWheels, kBody>() * D_cc.inverse() * D.topRightCorner<kBody, kWheels>();
}

/// Sum of [z; F][z; F]^H with [z; F] = R Z''.
Matrix8c wheel_moments(const WhittleMoments& moments, std::size_t bin, const LinearModel& model,
                       double omega) {
  Eigen::Matrix<Complex, 2 * kWheels, kCoordinates> R;
  R.topRows<kWheels>().setZero();
  R.topRightCorner<kWheels, kWheels>().diagonal().setConstant(-1.0 / (omega * omega));
  R.bottomRows<kWheels>() = (model.M.cast<Complex>() - (kJ / omega) * model.P.cast<Complex>() -
                             (model.Q / (omega * omega)).cast<Complex>())
                                .bottomRows<kWheels>();
  const Matrix8c same = R * moments.same[bin] * R.adjoint();
  const Matrix8c delayed = R * moments.delayed[bin] * R.adjoint();
  const auto front = [](Eigen::Index row) { return row % kWheels < 2; };
  Matrix8c J;
  for (Eigen::Index a = 0; a < J.rows(); ++a)
    for (Eigen::Index b = 0; b < J.cols(); ++b)
      J(a, b) = front(a) == front(b) ? same(a, b) : front(a) ? delayed(a, b) : std::conj(delayed(b, a));
  return J;
}

Speeds bins_of(std::span<const WhittleMoments* const> speeds, const Geometry& geometry,
               const LinearModel& without_tyres) {
  Speeds result;
  for (const WhittleMoments* moments : speeds) {
    if (moments->segments == 0.0) continue;
    const double delay_s = moments->delay_seconds / moments->segments;
    const double speed_m_s = (geometry.x_m[0] - geometry.x_m[2]) / delay_s;
    std::vector<Bin> bins;
    for (std::size_t k = 0; k < moments->same.size(); ++k) {
      const auto bin = static_cast<Eigen::Index>(k);
      if (moments->count(bin) == 0.0) continue;
      const double om = moments->omega(bin);
      const Complex later = std::polar(1.0, om * delay_s);
      bins.push_back({om, moments->count(bin),
                      1.0 / (1.0 + std::pow(om / (kPatchCorner_rad_m * speed_m_s), 2)),
                      Eigen::Vector4cd(1.0, 1.0, later, later), wheel_stiffness(without_tyres, om),
                      wheel_moments(*moments, k, without_tyres, om)});
    }
    if (!bins.empty()) result.push_back(std::move(bins));
  }
  return result;
}

/// The likelihood at one point, with its gradient and information.
struct Point {
  double value = 0.0;
  Theta gradient = Theta::Zero();
  Information information = Information::Zero();
};

/// Contribution of a bin at theta.
struct Terms {
  double log_phi;
  Eigen::Matrix4cd V;                        ///< sum of v v^H
  std::array<Eigen::Matrix4cd, kWheels> dV;  ///< by the stiffnesses
  Eigen::Matrix4cd X;                        ///< row i: dv_i by its stiffness, per v
  double log_gain;                           ///< log |det Gu| but for a constant
};

Terms terms(const Bin& bin, const Theta& theta, const Eigen::Vector4d& tyre, const Eigen::Vector4d& damper) {
  const Eigen::Vector4cd c =
      tyre.cwiseProduct(theta.head<kWheels>()).cast<Complex>() + kJ * bin.omega * damper.cast<Complex>();
  const Eigen::Vector4cd compliance = c.cwiseInverse();
  const Eigen::Vector4cd change =
      -tyre.cast<Complex>().cwiseProduct(compliance).cwiseProduct(compliance);  // d(1/c) by theta
  Eigen::Matrix<Complex, kWheels, 2 * kWheels> T;                               // v = T [z; F]
  T << Eigen::Matrix4cd::Identity(), Eigen::Matrix4cd(compliance.asDiagonal());
  const Eigen::Matrix<Complex, 2 * kWheels, kWheels> JT = bin.J * T.adjoint();

  Terms result;
  result.log_phi = std::log(bin.patch) - theta(kExponent) * std::log(bin.omega);
  result.V = T * JT;
  for (int i = 0; i < kWheels; ++i) {
    Eigen::Matrix4cd& d = result.dV[static_cast<std::size_t>(i)];
    d.setZero();
    d.row(i) = change(i) * JT.row(kWheels + i);
    d += d.adjoint().eval();
  }
  const Eigen::Matrix4cd road_per_height =
      Eigen::Matrix4cd::Identity() + Eigen::Matrix4cd(compliance.asDiagonal() * bin.K0);
  result.X = change.cwiseProduct(bin.advance).asDiagonal() * (bin.K0 * road_per_height.inverse()) *
             bin.advance.conjugate().asDiagonal();
  result.log_gain = -std::log(std::abs(road_per_height.determinant()));
  return result;
}

void add_speed(Point& point, const std::vector<Bin>& bins, const Theta& theta, const Eigen::Vector4d& tyre,
               const Eigen::Vector4d& damper) {
  std::vector<Terms> all;
  double N = 0.0;
  Eigen::Matrix4d L = Eigen::Matrix4d::Zero();
  std::array<Eigen::Matrix4d, kSearched> dL;
  dL.fill(Eigen::Matrix4d::Zero());
  for (const Bin& bin : bins) {
    all.push_back(terms(bin, theta, tyre, damper));
    const Terms& t = all.back();
    const double inverse_phi = std::exp(-t.log_phi);
    L += inverse_phi * t.V.real();
    for (std::size_t i = 0; i < kWheels; ++i) dL[i] += inverse_phi * t.dV[i].real();
    dL[kExponent] += std::log(bin.omega) * inverse_phi * t.V.real();
    N += bin.count;
  }
  L /= N;
  for (auto& d : dL) d /= N;
  const Eigen::Matrix4d L_inverse = L.inverse();
  point.value += N * std::log(L.determinant());
  for (int a = 0; a < kSearched; ++a)
    point.gradient(a) += N * L_inverse.cwiseProduct(dL[static_cast<std::size_t>(a)]).sum();

  std::array<Eigen::Matrix4d, kSearched> mean;  // of L^-1 Re S_a
  mean.fill(Eigen::Matrix4d::Zero());
  for (std::size_t k = 0; k < bins.size(); ++k) {
    const Bin& bin = bins[k];
    const Terms& t = all[k];
    point.value += bin.count * (kWheels * t.log_phi + 2.0 * t.log_gain);
    point.gradient(kExponent) -= bin.count * kWheels * std::log(bin.omega);
    std::array<Eigen::Matrix4cd, kSearched> S;  // L^-1 S_a
    for (int i = 0; i < kWheels; ++i) {
      // |det Gu| = prod |c| / |K0 + c| goes with the trace of dv/dct per v.
      point.gradient(i) += bin.count * 2.0 * (-t.X(i, i).real());
      Eigen::Matrix4cd XL = Eigen::Matrix4cd::Zero();
      XL.row(i) = -t.X.row(i) * L;
      S[static_cast<std::size_t>(i)] = L_inverse * (XL + XL.adjoint());
    }
    S[kExponent] = -std::log(bin.omega) * Eigen::Matrix4cd::Identity();
    for (std::size_t a = 0; a < kSearched; ++a) {
      mean[a] += bin.count * (L * S[a]).real();
      for (std::size_t b = 0; b < kSearched; ++b)
        point.information(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) +=
            bin.count * (S[a].transpose().cwiseProduct(S[b])).sum().real();
    }
  }
  for (auto& m : mean) m = (L_inverse * m).eval();
  for (std::size_t a = 0; a < kSearched; ++a)
    for (std::size_t b = 0; b < kSearched; ++b)
      point.information(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) -=
          mean[a].transpose().cwiseProduct(mean[b]).sum() / N;
}

}  // namespace

std::optional<WhittleTyres> whittle_tyres(std::span<const WhittleMoments* const> speeds,
                                          const Geometry& geometry, const ParameterVector& parameters,
                                          const std::bitset<kWheels>& free) {
  ParameterVector rest = parameters;
  rest.segment<kWheels>(kTyre).setZero();
  rest.segment<kWheels>(kTyreDamper).setZero();
  const Speeds bins = bins_of(speeds, geometry, linear_model(geometry, rest));
  if (bins.empty()) return std::nullopt;
  const Eigen::Vector4d tyre = parameters.segment<kWheels>(kTyre);
  const Eigen::Vector4d damper = parameters.segment<kWheels>(kTyreDamper);
  const auto at = [&](const Theta& theta) {
    Point point;
    for (const auto& of_speed : bins) add_speed(point, of_speed, theta, tyre, damper);
    for (int i = 0; i < kWheels; ++i)
      if (!free[static_cast<std::size_t>(i)]) {
        point.gradient(i) = 0.0;
        point.information.row(i).setZero();
        point.information.col(i).setZero();
        point.information(i, i) = 1.0;
      }
    return point;
  };

  Theta theta = Theta::Ones();
  theta(kExponent) = 2.0;
  Point point = at(theta);
  bool converged = false;
  for (int iteration = 0; iteration < kIterations && !converged; ++iteration) {
    if (!std::isfinite(point.value) || !point.information.allFinite()) return std::nullopt;
    const Eigen::LDLT<Information> information(point.information);
    if (information.info() != Eigen::Success || !information.isPositive()) return std::nullopt;
    Theta step = -information.solve(point.gradient);
    converged = step.dot(point.information * step) < kConverged * kConverged;
    if (converged) break;
    Point next;
    for (int halving = 0; halving < 10; ++halving, step /= 2.0) {
      Theta tried = theta + step;
      for (int i = 0; i < kWheels; ++i) tried(i) = std::clamp(tried(i), 1.0 - kSearch, 1.0 + kSearch);
      next = at(tried);
      if (next.value <= point.value || halving == 9) {
        theta = tried;
        break;
      }
    }
    point = next;
  }
  if (!converged || !std::isfinite(point.value)) return std::nullopt;
  const Information covariance = point.information.inverse();
  WhittleTyres result;
  result.tyre_n_m = tyre.cwiseProduct(theta.head<kWheels>());
  result.covariance = tyre.asDiagonal() * covariance.topLeftCorner<kWheels, kWheels>() * tyre.asDiagonal();
  for (int i = 0; i < kWheels; ++i)
    if (!free[static_cast<std::size_t>(i)]) {
      result.covariance.row(i).setZero();
      result.covariance.col(i).setZero();
    }
  result.exponent = theta(kExponent);
  result.exponent_sigma = std::sqrt(covariance(kExponent, kExponent));
  return result;
}

}  // namespace roadbalance
