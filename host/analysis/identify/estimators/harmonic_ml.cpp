#include "host/analysis/identify/estimators/harmonic_ml.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "common/vehicle/unbalance_response.hpp"
#include "host/analysis/identify/estimators/paper.hpp"

namespace roadbalance {
namespace {

using Complex = std::complex<double>;
constexpr double kRange = 0.3;            ///< of ct about what is known
constexpr int kStarts = 13;               ///< values of ct over that range where the search may begin
constexpr int kSteps = 30;                ///< of Gauss and Newton at most
constexpr double kTyreDifference = 1e-4;  ///< of ct
constexpr double kConverged = 1e-9;

/// Everything whitened, as one real least squares: y = A(ct) [Re U, Im U of each wheel].
class Lines {
 public:
  Lines(const BySpeed<LinePhasors>& drive, const Question& question) : question_(question) {
    for (const auto& [key, sums] : drive.at) {
      Speed speed{&sums, {}, {}, {}};
      for (int i = 0; i < kWheels; ++i)
        if (sums.has(i)) speed.wheels.push_back(i);
      if (speed.wheels.empty() || sums.bins < kCoordinates) continue;
      const Eigen::MatrixXcd K = sums.K(speed.wheels, speed.wheels);
      speed.rows = K.llt().matrixL().solve(Eigen::MatrixXcd::Identity(K.rows(), K.cols()));
      const LinePhasors::Spectrum S = sums.noise();
      speed.columns = S.llt().matrixL().solve(LinePhasors::Spectrum::Identity()).transpose();
      speeds_.push_back(speed);
    }
    for (int i = 0; i < kWheels; ++i) {
      const bool seen =
          std::any_of(speeds_.begin(), speeds_.end(), [&](const Speed& s) { return s.sums->has(i); });
      if (question.asks_for_unbalance(i) && seen) wheels_.push_back(i);
      if (question.asks_for_tyre(i)) tyres_.push_back(i);
    }
  }

  const std::vector<int>& wheels() const { return wheels_; }  ///< whose unbalance is found
  const std::vector<int>& tyres() const { return tyres_; }
  bool empty() const { return wheels_.empty(); }

  Eigen::VectorXd measured() const {
    return stacked(
        [](const Speed& speed) -> Eigen::MatrixXcd { return speed.sums->Z(speed.wheels, Eigen::all); });
  }

  Eigen::MatrixXd per_unbalance(const Eigen::Vector4d& tyre_n_m) const {
    ParameterVector parameters = question_.known;
    parameters.segment<kWheels>(kTyre) = tyre_n_m;
    const LinearModel model = linear_model(question_.geometry, parameters);
    Eigen::MatrixXd A(measured().size(), 2 * static_cast<Eigen::Index>(wheels_.size()));
    for (std::size_t w = 0; w < wheels_.size(); ++w)
      for (int part = 0; part < 2; ++part)
        A.col(static_cast<Eigen::Index>(2 * w) + part) = stacked([&](const Speed& speed) -> Eigen::MatrixXcd {
          const int i = wheels_[w];
          const Complex unit = part == 0 ? Complex(1.0) : Complex(0.0, 1.0);
          const Eigen::RowVectorXcd C = speed.sums->C.row(i);
          if (!speed.sums->has(i)) return Eigen::MatrixXcd::Zero(C(speed.wheels).size(), kCoordinates);
          const auto response = unbalance_response(model, i, speed.sums->omega()(i));
          return unit * C(speed.wheels).transpose() * response.transpose();
        });
    return A;
  }

 private:
  struct Speed {
    const LinePhasors* sums;
    std::vector<int> wheels;
    Eigen::MatrixXcd rows, columns;  ///< that whiten: rows R columns has independent entries of power 1
  };

  /// Real and imaginary parts, times sqrt 2, of the whitened rows [wheel x coordinate] of all speeds.
  template <typename Rows>
  Eigen::VectorXd stacked(const Rows& rows) const {
    std::vector<double> all;
    for (const Speed& speed : speeds_) {
      const Eigen::MatrixXcd white = std::sqrt(2.0) * (speed.rows * rows(speed) * speed.columns);
      for (const Complex value : white.reshaped()) {
        all.push_back(value.real());
        all.push_back(value.imag());
      }
    }
    return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
  }

  const Question& question_;
  std::vector<Speed> speeds_;
  std::vector<int> wheels_, tyres_;
};

/// The best U for these tyres and what it leaves.
struct Fit {
  Eigen::VectorXd unbalance;
  Eigen::VectorXd residual;
};
Fit fit(const Lines& lines, const Eigen::VectorXd& y, const Eigen::Vector4d& tyre_n_m) {
  const Eigen::MatrixXd A = lines.per_unbalance(tyre_n_m);
  const Eigen::VectorXd U = A.colPivHouseholderQr().solve(y);
  return {U, y - A * U};
}

/// Derivatives of the model's lines by the asked tyres with U held, then by U.
Eigen::MatrixXd jacobian(const Lines& lines, const Eigen::Vector4d& tyre_n_m, const Eigen::VectorXd& U) {
  const Eigen::MatrixXd A = lines.per_unbalance(tyre_n_m);
  const auto tyres = static_cast<Eigen::Index>(lines.tyres().size());
  Eigen::MatrixXd J(A.rows(), tyres + A.cols());
  for (Eigen::Index t = 0; t < tyres; ++t) {
    Eigen::Vector4d more = tyre_n_m, less = tyre_n_m;
    const int i = lines.tyres()[static_cast<std::size_t>(t)];
    const double step = kTyreDifference * tyre_n_m(i);
    more(i) += step;
    less(i) -= step;
    J.col(t) = (lines.per_unbalance(more) - lines.per_unbalance(less)) * U / (2.0 * step);
  }
  J.rightCols(A.cols()) = A;
  return J;
}

/// Takes for each tyre in turn the best of some values within the range.
Eigen::Vector4d start(const Lines& lines, const Eigen::VectorXd& y, const Eigen::Vector4d& known) {
  Eigen::Vector4d tyre = known;
  for (const int i : lines.tyres()) {
    double least = std::numeric_limits<double>::infinity(), best = known(i);
    for (int k = 0; k < kStarts; ++k) {
      tyre(i) = known(i) * (1.0 - kRange + 2.0 * kRange * k / (kStarts - 1));
      const double cost = fit(lines, y, tyre).residual.squaredNorm();
      if (cost < least) {
        least = cost;
        best = tyre(i);
      }
    }
    tyre(i) = best;
  }
  return tyre;
}

/// Steps of Gauss and Newton, halved until they make it better, kept within the range.
Eigen::Vector4d search(const Lines& lines, const Eigen::VectorXd& y, const Eigen::Vector4d& known) {
  Eigen::Vector4d tyre = start(lines, y, known);
  Fit now = fit(lines, y, tyre);
  for (int step = 0; step < kSteps && !lines.tyres().empty(); ++step) {
    const Eigen::MatrixXd J = jacobian(lines, tyre, now.unbalance);
    const Eigen::VectorXd size = J.colwise().norm();
    const Eigen::VectorXd move =
        (J * size.cwiseInverse().asDiagonal()).colPivHouseholderQr().solve(now.residual).cwiseQuotient(size);
    bool better = false;
    for (double part = 1.0; part > 1e-3 && !better; part /= 2.0) {
      Eigen::Vector4d next = tyre;
      for (std::size_t t = 0; t < lines.tyres().size(); ++t) {
        const int i = lines.tyres()[t];
        next(i) = std::clamp(tyre(i) + part * move(static_cast<Eigen::Index>(t)), known(i) * (1.0 - kRange),
                             known(i) * (1.0 + kRange));
      }
      const Fit then = fit(lines, y, next);
      better = then.residual.squaredNorm() < now.residual.squaredNorm() * (1.0 - kConverged);
      if (!better) continue;
      tyre = next;
      now = then;
    }
    if (!better) break;
  }
  return tyre;
}

}  // namespace

HarmonicLikelihood::HarmonicLikelihood(const Question& question)
    : question_(question), correlator_(wheels_asked_for_unbalance(question.asked)) {}

void HarmonicLikelihood::add(const Stretch& stretch) {
  correlator_.parts(stretch, [&](const LinePhasors& part) { sums_.add(stretch.speed_m_s, part); });
}

EstimatorAnswer HarmonicLikelihood::solve() const {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const BySpeed<LinePhasors> drive = sums_.all();
  const Lines lines(drive, question_);
  if (lines.empty()) {
    EstimatorAnswer answer = judged(question_, std::nullopt, std::nullopt);
    answer.diagnostics.emplace_back("no wheel asked for has an angle in steady driving");
    return answer;
  }
  const Eigen::Vector4d known = question_.known.segment<kWheels>(kTyre);
  const Eigen::VectorXd y = lines.measured();
  const Eigen::Vector4d tyre = search(lines, y, known);
  const Fit best = fit(lines, y, tyre);

  UnknownVector x = UnknownVector::Constant(kNone);
  UnknownMatrix covariance = UnknownMatrix::Constant(kNone);
  std::vector<int> place;  // of the Jacobian's columns
  for (const int i : lines.tyres()) place.push_back(kEstimatedTyre + i);
  for (const int i : lines.wheels()) {
    place.push_back(kEstimatedUnbalance + 2 * i);
    place.push_back(kEstimatedUnbalance + 2 * i + 1);
  }
  for (const int i : lines.tyres()) x(kEstimatedTyre + i) = tyre(i);
  x(std::vector<int>(place.begin() + static_cast<std::ptrdiff_t>(lines.tyres().size()), place.end())) =
      best.unbalance;
  const Eigen::MatrixXd J = jacobian(lines, tyre, best.unbalance);
  const Eigen::VectorXd size = J.colwise().norm();
  const Eigen::MatrixXd scaled = J * size.cwiseInverse().asDiagonal();
  covariance(place, place) = size.cwiseInverse().asDiagonal() * (scaled.transpose() * scaled).inverse() *
                             size.cwiseInverse().asDiagonal();
  EstimatorAnswer answer = judged(question_, x, covariance);
  for (const int i : lines.tyres())
    if (std::abs(tyre(i) / known(i) - 1.0) > kRange * (1.0 - 1e-6))
      answer.diagnostics.push_back(
          std::string(kWheelNames[static_cast<std::size_t>(i)]) +
          ": the lines do not tell the tyre's stiffness within 30 % of what is known");
  if (question_.asks_for_suspension())
    answer.diagnostics.emplace_back("the lines tell tyres and unbalances alone: no springs and dampers");
  return answer;
}

std::vector<EstimatorKind> harmonic_kinds() {
  return {
      {"harmonic", "the wheels' angles as instruments, least squares", false,
       [](const Question& question) -> std::unique_ptr<Estimator> {
         return std::make_unique<RelationEstimator>(
             question,
             RelationOptions{.instruments = RelationInstruments::kAngles, .road = RelationRoad::kNone});
       }},
      {"harmonic-ml", "maximum likelihood of the accelerations at the wheels' orders", false,
       [](const Question& question) -> std::unique_ptr<Estimator> {
         return std::make_unique<HarmonicLikelihood>(question);
       }},
  };
}

}  // namespace roadbalance
