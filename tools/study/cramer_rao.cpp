#include "tools/study/cramer_rao.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "common/vehicle/contact_patch.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;
using Response = Eigen::Matrix4cd;  ///< [wheel's acceleration x force on a wheel]

constexpr double kReferenceWave = 0.1;  ///< n0, 1/m
constexpr double kStep = 1e-4;          ///< of central differences, part of a parameter
constexpr double kGrid_hz = 0.1;        ///< of the random part's integral: the modes are 0.6 Hz wide and more

/// Place in ParameterVector of an unknown that is no unbalance.
int parameter_of(int unknown) {
  return unknown < kEstimatedTyre ? kSpring + unknown : kTyre + unknown - kEstimatedTyre;
}

/// Accelerations of the wheels for unit vertical forces on them.
Response response(const LinearModel& model, double om) {
  const Eigen::Matrix<Complex, kCoordinates, kCoordinates> dynamic =
      model.Q.cast<Complex>() + Complex(0.0, om) * model.P.cast<Complex>() -
      (om * om * model.M).cast<Complex>();
  const Eigen::Matrix<Complex, kCoordinates, kWheels> z =
      dynamic.partialPivLu().solve(model.W.cast<Complex>());
  return -om * om * z.bottomRows<kWheels>();
}

/// The drive's model with its derivatives with respect to what is asked.
class Sensitivities {
 public:
  explicit Sensitivities(const BoundQuestion& question) : question_(question) {
    nominal_ = linear_model(question.geometry, question.parameters);
    for (int a = 0; a < kUnknowns; ++a) {
      if (!question.asked[static_cast<std::size_t>(a)]) continue;
      asked_.push_back(a);
      if (a >= kEstimatedUnbalance) {
        up_.push_back(nominal_), down_.push_back(nominal_), step_.push_back(1.0);
        continue;
      }
      const int p = parameter_of(a);
      ParameterVector moved = question.parameters;
      const double step = kStep * question.parameters(p);
      moved(p) += step;
      up_.push_back(linear_model(question.geometry, moved));
      moved(p) -= 2.0 * step;
      down_.push_back(linear_model(question.geometry, moved));
      step_.push_back(step);
    }
  }

  const std::vector<int>& asked() const { return asked_; }

  /// Accelerations per road height, and its derivatives.
  Response road_response(double om) const { return with_tyres(nominal_, om); }
  Response road_derivative(std::size_t a, double om) const {
    return (with_tyres(up_[a], om) - with_tyres(down_[a], om)) / (2.0 * step_[a]);
  }
  Response force_response(double om) const { return response(nominal_, om); }

  /// Derivative of the accelerations' phasors at the order of `wheel`.
  Eigen::Vector4cd phasor_derivative(std::size_t a, int wheel, double om) const {
    const int unknown = asked_[a];
    if (unknown >= kEstimatedUnbalance) {
      if ((unknown - kEstimatedUnbalance) / 2 != wheel) return Eigen::Vector4cd::Zero();
      const Complex axis = (unknown - kEstimatedUnbalance) % 2 == 0 ? Complex(1, 0) : Complex(0, 1);
      return response(nominal_, om).col(wheel) * axis * om * om;
    }
    const Complex force = question_.unbalance_kg_m[static_cast<std::size_t>(wheel)] * om * om;
    return (response(up_[a], om).col(wheel) - response(down_[a], om).col(wheel)) * force / (2.0 * step_[a]);
  }

 private:
  static Response with_tyres(const LinearModel& model, double om) {
    const Eigen::Matrix4cd force = (model.S + Complex(0.0, om) * model.Sd).bottomRows<kWheels>();
    return response(model, om) * force;
  }

  const BoundQuestion& question_;
  LinearModel nominal_;
  std::vector<int> asked_;
  std::vector<LinearModel> up_, down_;
  std::vector<double> step_;
};

/// Adds the harmonic part of one speed.
void add_harmonic(const BoundQuestion& question, const Sensitivities& model, double speed_m_s,
                  Eigen::MatrixXd& information) {
  const std::size_t n = model.asked().size();
  for (int wheel = 0; wheel < kWheels; ++wheel) {
    const double om = speed_m_s / question.rolling_radius_m[static_cast<std::size_t>(wheel)];
    const Response G = model.road_response(om);
    const Eigen::Matrix4cd S = question.road.density(om, speed_m_s) * G *
                               question.road.coherence(question.geometry, om, speed_m_s) * G.adjoint();
    const auto factors = S.partialPivLu();
    Eigen::MatrixXcd mu(kWheels, n);
    for (std::size_t a = 0; a < n; ++a)
      mu.col(static_cast<Eigen::Index>(a)) = model.phasor_derivative(a, wheel, om);
    const auto size = static_cast<Eigen::Index>(n);
    information.topLeftCorner(size, size) +=
        0.5 * question.seconds * (mu.adjoint() * factors.solve(mu)).real();
  }
}

/// Adds the random part of one speed: with S = G R G^H, S^-1 dS is similar to X + R X^H R^-1, X = G^-1 dG,
/// and for the logarithm of a level or the exponent to a multiple of the unit matrix.
void add_random(const BoundQuestion& question, const Sensitivities& model, double speed_m_s,
                Eigen::Index level, Eigen::Index exponent, Eigen::MatrixXd& information) {
  const std::size_t n = model.asked().size();
  const double first_hz = std::max(question.low_hz, 0.5 * kGrid_hz);
  for (double f = first_hz; f < question.high_hz; f += kGrid_hz) {
    const double om = 2.0 * pi * f;
    const auto inverse = model.road_response(om).partialPivLu();
    const Eigen::Matrix4cd R = question.road.coherence(question.geometry, om, speed_m_s);
    const Eigen::Matrix4cd inverse_R = R.inverse();
    std::vector<std::pair<Eigen::Index, Eigen::Matrix4cd>> part;
    for (std::size_t a = 0; a < n; ++a) {
      if (model.asked()[a] >= kEstimatedUnbalance) continue;
      const Eigen::Matrix4cd X = inverse.solve(model.road_derivative(a, om));
      part.emplace_back(static_cast<Eigen::Index>(a), X + R * X.adjoint() * inverse_R);
    }
    if (level >= 0) part.emplace_back(level, Eigen::Matrix4cd::Identity());
    if (exponent >= 0)
      part.emplace_back(exponent, -std::log(f / (speed_m_s * kReferenceWave)) * Eigen::Matrix4cd::Identity());
    for (const auto& [a, A] : part)
      for (const auto& [b, B] : part)
        information(a, b) += question.seconds * kGrid_hz * (A * B).trace().real();
  }
}

}  // namespace

Eigen::Matrix4cd RoadStatistics::coherence(const Geometry& geometry, double om, double speed_m_s) const {
  const double c2 = rear_coherence2, r = left_right_correlation;
  const double rear = c2 * r + (1.0 - c2) * rear_own_correlation;
  const auto delayed = [&](double part, std::size_t front) {
    const double wheelbase_m = geometry.x_m[front] - geometry.x_m[front + 2];
    return std::sqrt(c2) * part * std::polar(1.0, -om * wheelbase_m / speed_m_s);
  };
  Eigen::Matrix4cd R = Eigen::Matrix4cd::Identity();
  R(0, 1) = R(1, 0) = r;
  R(2, 3) = R(3, 2) = rear;
  for (int f = 0; f < 2; ++f)
    for (int side = 0; side < 2; ++side) {
      R(2 + side, f) = delayed(side == f ? 1.0 : r, static_cast<std::size_t>(f));
      R(f, 2 + side) = std::conj(R(2 + side, f));
    }
  return R;
}

double RoadStatistics::density(double om, double speed_m_s) const {
  const double w2 = 2.0 * pi * kPatchWave_1_m * speed_m_s;
  const double q2 = 2.0 * pi * pi * kReferenceWave * kReferenceWave * roughness_m3 * speed_m_s;
  const double wave = om / (2.0 * pi * speed_m_s * kReferenceWave);
  return q2 / (om * om) * w2 * w2 / (om * om + w2 * w2) * std::pow(wave, 2.0 - exponent);
}

UnknownMatrix cramer_rao(const BoundQuestion& question) {
  const Sensitivities model(question);
  const auto n = static_cast<Eigen::Index>(model.asked().size());
  const auto speeds = static_cast<Eigen::Index>(question.speeds_m_s.size());
  const bool levels = question.random_part && question.level_free;
  const bool exponent = question.random_part && question.exponent_free;
  const Eigen::Index all = n + (levels ? speeds : 0) + (exponent ? 1 : 0);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(all, all);
  for (Eigen::Index s = 0; s < speeds; ++s) {
    const double speed_m_s = question.speeds_m_s[static_cast<std::size_t>(s)];
    add_harmonic(question, model, speed_m_s, information);
    if (question.random_part)
      add_random(question, model, speed_m_s, levels ? n + s : -1, exponent ? all - 1 : -1, information);
  }
  // Unknowns in units in which each alone would be known to 1.
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) throw std::invalid_argument("cramer_rao: something asked has no effect");
  const Eigen::FullPivLU<Eigen::MatrixXd> factors(scale.asDiagonal() * information * scale.asDiagonal());
  if (!factors.isInvertible()) throw std::invalid_argument("cramer_rao: what is asked cannot be told apart");
  const Eigen::MatrixXd covariance = scale.asDiagonal() * factors.inverse() * scale.asDiagonal();
  UnknownMatrix result = UnknownMatrix::Zero();
  for (Eigen::Index a = 0; a < n; ++a)
    for (Eigen::Index b = 0; b < n; ++b)
      result(model.asked()[static_cast<std::size_t>(a)], model.asked()[static_cast<std::size_t>(b)]) =
          covariance(a, b);
  return result;
}

WheelBound wheel_bound(const UnknownMatrix& covariance, const BoundQuestion& question, int wheel) {
  const int tyre = kEstimatedTyre + wheel, re = kEstimatedUnbalance + 2 * wheel;
  const Complex U = question.unbalance_kg_m[static_cast<std::size_t>(wheel)];
  Eigen::Matrix2d turn;
  turn << U.real(), U.imag(), -U.imag(), U.real();
  const Eigen::Matrix2d of_part =
      turn * covariance.block<2, 2>(re, re) * turn.transpose() / (std::norm(U) * std::norm(U));
  return {100.0 * std::sqrt(covariance(tyre, tyre)) / question.parameters(kTyre + wheel),
          100.0 * std::sqrt(of_part(0, 0)), 180.0 / pi * std::sqrt(of_part(1, 1)),
          std::sqrt(covariance(re, re)), std::sqrt(covariance(re + 1, re + 1))};
}

}  // namespace roadbalance
