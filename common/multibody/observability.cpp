#include "common/multibody/observability.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <complex>
#include <cstdio>

namespace roadbalance {
namespace {

using Complex = std::complex<double>;

/// Values below this part of the largest response are rounding of the equations, not a response.
constexpr double kNothing = 1e-9;

Eigen::MatrixXd rows_of(const Eigen::MatrixXd& all, const std::vector<int>& chosen) {
  return chosen.empty() ? all : Eigen::MatrixXd(all(chosen, Eigen::all));
}

/// "0.71 inner - 0.71 outer"; a factor common to all planes has no meaning.
std::string combination(const Eigen::VectorXcd& direction, const std::vector<std::string>& plane) {
  // The first of the largest is positive; rounding does not choose among equals.
  const double most = direction.cwiseAbs().maxCoeff();
  Eigen::Index largest = 0;
  while (std::abs(direction(largest)) < (1.0 - 1e-6) * most) ++largest;
  const Eigen::VectorXcd turned = direction / (direction(largest) / std::abs(direction(largest)));
  std::string text;
  for (Eigen::Index p = 0; p < turned.size(); ++p) {
    const double part = turned(p).real();
    if (std::abs(turned(p)) < 1e-6) continue;
    char number[64];
    if (std::abs(turned(p).imag()) < 1e-6)
      std::snprintf(number, sizeof number, "%s%.2f ",
                    text.empty() ? (part < 0 ? "-" : "")
                    : part < 0   ? " - "
                                 : " + ",
                    std::abs(part));
    else
      std::snprintf(number, sizeof number, "%s(%.2f %+.2fj) ", text.empty() ? "" : " + ", part,
                    turned(p).imag());
    text += number + plane[static_cast<std::size_t>(p)];
  }
  return text;
}

std::string sentence_of(const RotorObservability& rotor) {
  if (rotor.unobservable.cols() == 0) return "";
  const auto count = [](Eigen::Index n) { return std::to_string(n); };
  std::string text = "rotor " + rotor.rotor + ": of its " + count(rotor.unobservable.rows()) +
                     (rotor.unobservable.rows() == 1 ? " plane" : " planes") + " the sensors tell " +
                     count(rotor.observable.cols()) +
                     (rotor.observable.cols() == 1 ? " combination" : " combinations") + "; unobservable is ";
  for (Eigen::Index k = 0; k < rotor.unobservable.cols(); ++k)
    text += (k ? " and " : "") + combination(rotor.unobservable.col(k), rotor.plane);
  return text;
}

}  // namespace

std::vector<RotorObservability> observability(const AffineModel& model, const ModelMatrices& at,
                                              const std::vector<int>& sensors,
                                              const std::vector<double>& omega) {
  const Eigen::MatrixXd acceleration = rows_of(model.acceleration, sensors),
                        tilt = rows_of(model.tilt, sensors);
  const Eigen::Index rows = acceleration.rows();
  std::vector<RotorObservability> all;
  for (std::size_t r = 0; r < model.rotor.size(); ++r) {
    RotorObservability rotor;
    rotor.rotor = model.rotor[r];
    std::vector<Eigen::Index> column;
    for (std::size_t p = 0; p < model.plane.size(); ++p)
      if (model.plane[p].rotor == static_cast<int>(r)) {
        column.push_back(static_cast<Eigen::Index>(p));
        rotor.plane.push_back(model.plane[p].name);
      }
    const Eigen::MatrixXcd force = model.up(Eigen::all, column).cast<Complex>() -
                                   Complex(0.0, 1.0) * model.forward(Eigen::all, column).cast<Complex>();
    const auto planes = static_cast<Eigen::Index>(column.size());
    Eigen::MatrixXcd stacked(rows * static_cast<Eigen::Index>(omega.size()), planes);
    for (std::size_t k = 0; k < omega.size(); ++k) {
      const double om = omega[k], om2 = om * om;
      const Eigen::MatrixXcd dynamic =
          at.Q.cast<Complex>() + Complex(0.0, om) * at.P.cast<Complex>() - (om2 * at.M).cast<Complex>();
      stacked.middleRows(static_cast<Eigen::Index>(k) * rows, rows) =
          (tilt - om2 * acceleration).cast<Complex>() * dynamic.partialPivLu().solve(om2 * force);
    }
    if (stacked.size() == 0) stacked = Eigen::MatrixXcd::Zero(1, planes);  // no sensor shows anything
    const Eigen::JacobiSVD<Eigen::MatrixXcd> svd(stacked, Eigen::ComputeFullV | Eigen::ComputeThinU);
    Eigen::Index rank = 0;
    while (rank < svd.singularValues().size() && svd.singularValues()(rank) > 0.0 &&
           svd.singularValues()(rank) > kNothing * svd.singularValues()(0))
      ++rank;
    rotor.observable = svd.matrixV().leftCols(rank);
    rotor.unobservable = svd.matrixV().rightCols(planes - rank);
    rotor.sentence = sentence_of(rotor);
    all.push_back(std::move(rotor));
  }
  return all;
}

}  // namespace roadbalance
